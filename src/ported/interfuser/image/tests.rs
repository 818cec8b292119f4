use super::*;

/// The pixels of a quadrangle as OpenCV 4.8.1 fills it, as text.
fn drawn(corners: Corners) -> Vec<String> {
    let mut image = Image::default();
    image.fill(&corners);
    let bounds = Bounds::around(&corners);
    let white = |x: i64, y: i64| image.rows[y as usize][(x >> 6) as usize] >> (x & 63) & 1 == 1;
    let columns = bounds.left.max(0)..=bounds.right.min(SIZE - 1);
    let line = |y: i64| columns.clone().map(|x| if white(x, y) { '#' } else { '.' }).collect();
    (bounds.top.max(0)..=bounds.bottom.min(SIZE - 1)).map(line).collect()
}

#[test]
fn quadrangles_are_filled_as_opencv_fills_them() {
    let cases: [(Corners, &[&str]); 5] = [
        (
            [(20, 10), (27, 13), (24, 20), (17, 17)],
            &[
                "...##......",
                "...####....",
                "..#######..",
                "..#########",
                ".##########",
                ".#########.",
                "##########.",
                "#########..",
                "..#######..",
                "....####...",
                "......##...",
            ],
        ),
        (
            [(-6, 50), (5, 44), (9, 52), (-2, 58)],
            &[
                ".....#....",
                "...####...",
                ".######...",
                "########..",
                "########..",
                "#########.",
                "#########.",
                "##########",
                "##########",
                "#########.",
                "#######...",
                "#####.....",
                "###.......",
                "#.........",
                "..........",
            ],
        ),
        ([(50, 60), (58, 60), (58, 63), (50, 63)], &["#########", "#########", "#########", "#########"]),
        (
            [(100, 172), (112, 178), (108, 186), (96, 180)],
            &[
                "....##...........",
                "...#####.........",
                "...#######.......",
                "..##########.....",
                "..############...",
                ".###############.",
                ".################",
                "#################",
            ],
        ),
        (
            [(30, 30), (45, 33), (44, 36), (29, 33)],
            &[
                ".###.............",
                ".########........",
                "##############...",
                "#################",
                "...##############",
                "........########.",
                ".............###.",
            ],
        ),
    ];
    for (corners, pixels) in cases {
        assert_eq!(drawn(corners), pixels, "{corners:?}");
    }
}

#[test]
fn a_rectangle_without_direction_is_one_pixel() {
    let rectangle =
        Rectangle { centre: EgoVector::new(0.0, -5.0), direction: EgoVector::zeros(), half: EgoVector::new(4.95, 2.2) };
    assert_eq!(rectangle.corners(), [(90, 65); 4]);
    let mut image = Image::default();
    image.fill(&rectangle.corners());
    assert_eq!((image.pixels(), image.crop_pixels(), image.crop(65)), (1, 1, 1 << 50));
}

#[test]
fn corners_are_rounded_half_to_even() {
    let at =
        |x: f64| Rectangle { centre: EgoVector::new(x, 0.0), direction: EgoVector::zeros(), half: EgoVector::zeros() };
    assert_eq!([0.1, 0.3, 0.5].map(|x| at(x).corners()[0].0), [90, 92, 92]);
}

#[test]
fn a_cleared_image_is_black() {
    let mut image = Image::default();
    image.fill(&[(170, 170), (190, 175), (180, 190), (165, 185)]);
    assert!(image.pixels() > 0 && image.crop_pixels() == 0);
    image.clear();
    assert_eq!(image.pixels(), 0);
    image.fill(&[(200, 10), (220, 10), (220, 20), (200, 20)]);
    assert_eq!(image.pixels(), 0, "outside");
}
