use super::{CampaignReport, Error, OverviewFiles, RunOptions, RunReport};
use results::report::{self, Overview, Variant, WriteError};

/// The stem of the files of an overview.
const OVERVIEW: &str = "overview";

/// Writes the overview of a call with several reports; `None` for a single report.
pub(super) fn write_overview(options: &RunOptions, run: &RunReport) -> Result<Option<OverviewFiles>, Error> {
    let reports: Vec<&CampaignReport> = run.reports().collect();
    if reports.len() < 2 {
        return Ok(None);
    }
    let folder = |report: &CampaignReport| report.folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let settings = reports.iter().map(|report| {
        let seed = options.seeds.as_ref().map(|_| format!("seed = {}", report.manifest.seed));
        report.manifest.settings.iter().cloned().chain(seed).collect()
    });
    let settings: Vec<Vec<String>> = settings.collect();
    let variants: Vec<Variant<'_>> = reports
        .iter()
        .zip(&settings)
        .map(|(report, settings)| Variant {
            report: folder(report),
            settings,
            cells: &report.cells,
            drivers: &report.drivers,
            searches: &report.searches,
            doubts: &report.doubts,
        })
        .collect();
    let page = options.out.join(format!("{OVERVIEW}.html"));
    let table = options.out.join(format!("{OVERVIEW}.csv"));
    let failed = |source| options.keep(WriteError::Table { name: OVERVIEW.into(), source });
    let overview = Overview::new(&variants).map_err(failed)?;
    let frame = overview.table().map_err(failed)?;
    report::write_csv(&table, &frame).map_err(|error| options.keep(error))?;
    let html = report::overview_page(&overview, &reports[0].manifest.version).map_err(failed)?;
    report::write_file(&page, html.as_bytes()).map_err(|error| options.keep(error))?;
    let text = report::overview_for_terminal(&overview).map_err(failed)?;
    Ok(Some(OverviewFiles { page, text }))
}
