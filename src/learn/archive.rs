//! Named arrays in the safetensors format, bit for bit.

use std::collections::BTreeMap;

use safetensors::{Dtype, SafeTensors};
use serde::Serialize;

use super::checkpoint_error::CheckpointError;

/// One entry of the header.
#[derive(Serialize)]
struct Entry {
    dtype: &'static str,
    shape: Vec<usize>,
    data_offsets: [usize; 2],
}

/// A file under construction; the same calls give the same bytes.
#[derive(Default)]
pub(super) struct Writer {
    header: Vec<(String, Entry)>,
    data: Vec<u8>,
}

impl Writer {
    /// Adds an array of any type, row by row.
    pub(super) fn add<N: Number>(&mut self, name: &str, shape: &[usize], values: impl IntoIterator<Item = N>) {
        let start = self.data.len();
        for value in values {
            value.append(&mut self.data);
        }
        let entry = Entry { dtype: N::NAME, shape: shape.to_vec(), data_offsets: [start, self.data.len()] };
        self.header.push((name.to_owned(), entry));
    }

    /// Adds a vector.
    pub(super) fn vector<N: Number>(&mut self, name: &str, values: &[N]) {
        self.add(name, &[values.len()], values.iter().copied());
    }

    /// Assembles the file: the header's length, the header in the order of the calls and padded to eight bytes, the data.
    pub(super) fn finish(self, metadata: &BTreeMap<String, String>) -> Vec<u8> {
        let json = |text: Result<String, serde_json::Error>| text.expect("strings and numbers have a form in JSON");
        let mut entries = vec![format!("\"__metadata__\":{}", json(serde_json::to_string(metadata)))];
        let entry = |(name, entry): &(String, Entry)| format!("\"{name}\":{}", json(serde_json::to_string(entry)));
        entries.extend(self.header.iter().map(entry));
        let mut header = format!("{{{}}}", entries.join(","));
        header.push_str(&" ".repeat(header.len().next_multiple_of(8) - header.len()));
        [&(header.len() as u64).to_le_bytes(), header.as_bytes(), &self.data].concat()
    }
}

/// A type of number that arrays can hold.
pub(super) trait Number: Copy {
    /// The type's name in the header.
    const NAME: &'static str;
    const TYPE: Dtype;
    /// The number of bytes.
    const SIZE: usize;

    /// Writes the number, least significant byte first.
    fn append(self, data: &mut Vec<u8>);

    /// Reads the number from its bytes; `None` if it is not finite.
    fn parse(bytes: &[u8]) -> Option<Self>;
}

macro_rules! number {
    ($type:ty, $name:literal, $dtype:expr, $finite:expr) => {
        impl Number for $type {
            const NAME: &'static str = $name;
            const TYPE: Dtype = $dtype;
            const SIZE: usize = size_of::<$type>();

            fn append(self, data: &mut Vec<u8>) {
                data.extend(self.to_le_bytes());
            }

            fn parse(bytes: &[u8]) -> Option<Self> {
                Some(<$type>::from_le_bytes(*bytes.first_chunk()?)).filter($finite)
            }
        }
    };
}

number!(f32, "F32", Dtype::F32, |x| x.is_finite());
number!(f64, "F64", Dtype::F64, |x| x.is_finite());
number!(u64, "U64", Dtype::U64, |_| true);
number!(u8, "U8", Dtype::U8, |_| true);

/// An array that has been read.
pub(super) struct Array<N> {
    pub(super) name: String,
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<N>,
}

impl<N: Number> Array<N> {
    /// The error that the shape is not the expected one.
    pub(super) fn misshapen(self) -> CheckpointError {
        CheckpointError::Shape { name: self.name, found: self.shape }
    }
}

/// Reads an array of finite numbers.
pub(super) fn read<N: Number>(tensors: &SafeTensors<'_>, name: &str) -> Result<Array<N>, CheckpointError> {
    let tensor = tensors.tensor(name).map_err(|_| CheckpointError::Missing { name: name.to_owned() })?;
    if tensor.dtype() != N::TYPE {
        let (name, found) = (name.to_owned(), format!("{:?}", tensor.dtype()));
        return Err(CheckpointError::Type { name, expected: N::NAME, found });
    }
    let values: Option<Vec<N>> = tensor.data().chunks_exact(N::SIZE).map(N::parse).collect();
    let values = values.ok_or_else(|| CheckpointError::NonFinite { name: name.to_owned() })?;
    Ok(Array { name: name.to_owned(), shape: tensor.shape().to_vec(), values })
}

/// Reads a vector of a known length.
pub(super) fn read_vector<N: Number>(
    tensors: &SafeTensors<'_>,
    name: &str,
    length: usize,
) -> Result<Vec<N>, CheckpointError> {
    let array = read(tensors, name)?;
    if array.shape == [length] { Ok(array.values) } else { Err(array.misshapen()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_of_all_types_return_bit_for_bit() {
        let mut writer = Writer::default();
        writer.vector("a", &[0.1f32, -0.0, f32::MIN_POSITIVE / 8.0]);
        writer.vector("b", &[0.1f64, -0.0, f64::MIN_POSITIVE / 8.0]);
        writer.vector("c", &[u64::MAX, 1 << 53 | 1]);
        writer.vector::<u64>("none", &[]);
        writer.vector("d", b"odd");
        let bytes = writer.finish(&BTreeMap::new());
        let tensors = SafeTensors::deserialize(&bytes).unwrap();
        let a: Vec<u32> = read_vector::<f32>(&tensors, "a", 3).unwrap().into_iter().map(f32::to_bits).collect();
        assert_eq!(a, [0.1f32, -0.0, f32::MIN_POSITIVE / 8.0].map(f32::to_bits));
        let b: Vec<u64> = read_vector::<f64>(&tensors, "b", 3).unwrap().into_iter().map(f64::to_bits).collect();
        assert_eq!(b, [0.1f64, -0.0, f64::MIN_POSITIVE / 8.0].map(f64::to_bits));
        assert_eq!(read_vector::<u64>(&tensors, "c", 2).unwrap(), [u64::MAX, 1 << 53 | 1]);
        assert_eq!(read_vector::<u64>(&tensors, "none", 0).unwrap(), [0; 0]);
        assert_eq!(read_vector::<u8>(&tensors, "d", 3).unwrap(), b"odd");
        assert!(
            matches!(read_vector::<u8>(&tensors, "d", 4), Err(CheckpointError::Shape { found, .. }) if found == [3])
        );
        assert!(matches!(read::<u64>(&tensors, "a"), Err(CheckpointError::Type { expected: "U64", .. })));
    }
}
