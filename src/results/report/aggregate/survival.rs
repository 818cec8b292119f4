/// The median of censored times with its 95 % interval; an end that the data do not determine is none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MedianTime {
    /// The median; none when fewer than half of the events were observed.
    pub median: Option<f64>,
    /// Low end of the interval.
    pub low: Option<f64>,
    /// High end of the interval.
    pub high: Option<f64>,
}

/// Estimates the median time to an event from times and whether the event was observed at them; the others are censored.
///
/// # Source
/// Kaplan and Meier, JASA 53, 1958; interval of Brookmeyer and Crowley, Biometrics 38, 1982, over the band of Greenwood's variance on the
/// log-log scale, as in lifelines. When no run is left, the band has no upper end, as in R.
pub fn median_time(times: &[(f64, bool)]) -> MedianTime {
    const Z: f64 = 1.959_963_984_540_054;
    let mut sorted = times.to_vec();
    // A run that is censored at a time was still at risk at that time.
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let (mut survival, mut variance) = (1.0, 0.0);
    let mut found = MedianTime::default();
    let mut next = 0;
    while next < sorted.len() {
        let time = sorted[next].0;
        let here = sorted[next..].iter().take_while(|(t, _)| *t == time).count();
        let (at_risk, events) =
            ((sorted.len() - next) as f64, sorted[next..next + here].iter().filter(|(_, seen)| *seen).count() as f64);
        next += here;
        if events == 0.0 {
            continue;
        }
        survival *= 1.0 - events / at_risk;
        if survival <= 0.5 {
            found.median = found.median.or(Some(time));
        }
        if survival > 0.0 {
            variance += events / (at_risk * (at_risk - events));
            let theta = Z * f64::sqrt(variance) / libm::log(survival);
            let (low, high) = (libm::pow(survival, libm::exp(-theta)), libm::pow(survival, libm::exp(theta)));
            if low <= 0.5 {
                found.low = found.low.or(Some(time));
            }
            if high <= 0.5 {
                found.high = found.high.or(Some(time));
            }
        } else {
            // The low end of the band is 0 there.
            found.low = found.low.or(Some(time));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Recorded from lifelines by `tests/reference/kaplan_meier/record_medians.py`.
    const RECORDED: &str = include_str!("../../../../tests/reference/kaplan_meier/medians.json");

    #[test]
    fn medians_and_intervals_are_those_of_lifelines() {
        let recorded: serde_json::Value = serde_json::from_str(RECORDED).unwrap();
        let mut cases = 0;
        for (name, case) in recorded.as_object().unwrap().iter().filter(|(name, _)| *name != "version") {
            let list = |key: &str| case[key].as_array().unwrap().clone();
            let times: Vec<(f64, bool)> = list("times")
                .iter()
                .zip(&list("found"))
                .map(|(time, found)| (time.as_f64().unwrap(), found.as_i64() == Some(1)))
                .collect();
            let ends = list("interval");
            let wanted = MedianTime { median: case["median"].as_f64(), low: ends[0].as_f64(), high: ends[1].as_f64() };
            assert_eq!(median_time(&times), wanted, "{name}");
            cases += 1;
        }
        assert_eq!(cases, 4);
        assert_eq!(median_time(&[]), MedianTime::default());
        assert_eq!(median_time(&[(5.0, false), (5.0, false)]), MedianTime::default(), "all censored");
        // lifelines: 1..6 of seven times. With six, its high end is the last time, where R and this code have none.
        let first = |n: u32| median_time(&(1..=n).map(|time| (f64::from(time), true)).collect::<Vec<_>>());
        assert_eq!((first(7).low, first(7).high), (Some(1.0), Some(6.0)));
        assert_eq!((first(6).low, first(6).high), (Some(1.0), None));
    }
}
