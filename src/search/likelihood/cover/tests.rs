use super::*;

#[test]
fn looks_share_five_percent() {
    let all: f64 = (0..100_000).map(share_of_look).sum();
    assert!(all < 0.05 && all > 0.0499, "{all}");
    // 0 of 149 at 0.025: 1 - 0.025^(1/149) = 0.02445; the least for 0.05 is ln 0.025 / ln 0.95 = 71.9.
    assert_eq!(size(0, 0.05, 0.025), 72);
    assert!((bound(0, 149, 0.025) - (1.0 - libm::pow(0.025, 1.0 / 149.0))).abs() < 1e-12);
    for worse in [1, 3, 9] {
        let n = size(worse, 0.02, 0.01);
        assert!(bound(worse, n, 0.01) <= 0.02 && bound(worse, n - 1, 0.01) > 0.02);
    }
}

#[test]
fn a_design_has_a_point_in_every_slice() {
    let points = latin_hypercube(50, 3, &mut Seed::root(1).stream());
    for dimension in 0..3 {
        let mut slices: Vec<usize> = points.iter().map(|at| (at[dimension] * 50.0) as usize).collect();
        slices.sort_unstable();
        assert_eq!(slices, (0..50).collect::<Vec<_>>());
    }
}

#[test]
fn a_regression_finds_a_plane() {
    let point = |x: f64, y: f64| Point { at: vec![x, y], failed: x + y > 1.0, sampled: Sampled::Design };
    let grid = (0..100).map(|k| point(f64::from(k % 10) / 9.0 + 0.001, f64::from(k / 10) / 9.0));
    let picture = Picture::of(2, &grid.collect::<Vec<_>>());
    assert_eq!((picture.share(&[0.1, 0.1]), picture.share(&[0.9, 0.9])), (0.0, 1.0));
    // The last points that pass are at x + y = 8 / 9 and the first that fail at 1, so the boundary is between them.
    let middle = picture.share(&[0.472, 0.472]);
    assert!((middle - 0.5).abs() < 0.2, "{middle}");
    assert!(picture.share(&[0.4, 0.4]) < 0.2 && picture.share(&[0.55, 0.55]) > 0.8);
    assert_eq!(Picture::of(2, &[]).share(&[0.5, 0.5]), 0.0, "nothing is known");
}
