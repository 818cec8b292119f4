//! Tables as text for other programs.

use polars::prelude::{AnyValue, DataFrame, PolarsError, PolarsResult};
use polars_io::SerWriter;
use polars_io::csv::write::CsvWriter;
use serde_json::{Map, Value};

/// A table as CSV, with a header.
pub fn csv_text(table: &DataFrame) -> String {
    let mut bytes = Vec::new();
    CsvWriter::new(&mut bytes).finish(&mut table.clone()).expect("a table of texts and numbers has a form in CSV");
    String::from_utf8(bytes).expect("CSV of texts is UTF-8")
}

/// Whether a spreadsheet takes a text for a formula. No text of a report is one; commands are numbers, of which the first may be negative.
pub fn is_formula(text: &str) -> bool {
    let is_of_numbers = || text.bytes().all(|byte| byte.is_ascii_digit() || b" .@-e".contains(&byte));
    text.starts_with(['=', '+', '@', '\t', '\r']) || text.starts_with('-') && !is_of_numbers()
}

/// Checks that no cell of a table from elsewhere is a formula.
///
/// # Errors
/// The first that is.
pub fn without_formulas(table: DataFrame) -> PolarsResult<DataFrame> {
    let texts = table.columns().iter().filter_map(|column| column.str().ok());
    let wrong = texts.flat_map(|texts| texts.iter().flatten()).find(|text| is_formula(text));
    let wrong = wrong.map(|text| PolarsError::ComputeError(format!("`{text:.40}` is no name").into()));
    wrong.map_or(Ok(table), Err)
}

/// The rows of a table as JSON objects. A missing value and one that is not a number are `null`.
pub fn json_rows(table: &DataFrame) -> Vec<Value> {
    let object = |row: usize| {
        let field = |column: &polars::prelude::Column| {
            (column.name().to_string(), column.get(row).map_or(Value::Null, |value| json(&value)))
        };
        Value::Object(table.columns().iter().map(field).collect::<Map<_, _>>())
    };
    (0..table.height()).map(object).collect()
}

fn json(value: &AnyValue<'_>) -> Value {
    match value {
        AnyValue::Null => Value::Null,
        AnyValue::Boolean(truth) => (*truth).into(),
        AnyValue::UInt32(number) => (*number).into(),
        AnyValue::UInt64(number) => (*number).into(),
        AnyValue::Float64(number) => (*number).into(),
        other => other.get_str().map_or(Value::Null, Into::into),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::record::{Column, Table};

    #[test]
    fn rows_have_the_same_values_in_both_forms() {
        let table = Table::new("t", "")
            .column(Column::<String>::new("who", "", "").of(|row: &(Option<f64>, u64)| format!("a, {}", row.1)))
            .column(Column::<f64>::new("rate", "", "").of(|row: &(Option<f64>, u64)| row.0))
            .frame(&[(Some(0.5), 1), (None, 2)]);
        for cell in ["=1+1", "+1", "-1+A1", "@SUM(A1)"] {
            let cells =
                Table::new("t", "").column(Column::<String>::new("who", "", "").of(|row: &&str| row.to_string()));
            let refused = without_formulas(cells.frame(&[cell])).unwrap_err();
            assert_eq!(refused.to_string(), format!("`{cell}` is no name"));
        }
        assert!(without_formulas(table.clone()).is_ok() && !is_formula("-1.5@2.25 3e-7@0"));
        assert_eq!(csv_text(&table), "who,rate\n\"a, 1\",0.5\n\"a, 2\",\n");
        assert_eq!(json_rows(&table), [json!({ "who": "a, 1", "rate": 0.5 }), json!({ "who": "a, 2", "rate": null })]);
    }
}
