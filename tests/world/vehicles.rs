//! Brakes, drives and turning circles of cars: documented values and closed forms.

use world::sim::{Control, VehicleBlueprint, VehicleState};

#[test]
fn emergency_stop_of_the_model_3_is_the_documented_one() {
    let car = VehicleBlueprint::model3();
    let half = Control { brake: 0.5, ..Control::default() };
    assert!((car.acceleration(half, 7.0) + 3.505 + 2.359).abs() < 1e-9, "brake and engine drag");
    assert!((car.acceleration(half, 3.0) + 7.01 + 1.011).abs() < 1e-9, "twice as hard below 5 m/s");
}

#[test]
fn the_drive_of_the_model_3_is_that_of_its_dump() {
    let (mass, gears, radius, inertia, clutch) = (1845.0, 8.0, 0.37, 1.0, 10.0);
    let ratio: f64 = gears / radius;
    let moved = mass + inertia * ratio * ratio;
    let rise = 100.0 / (1890.76 * std::f64::consts::TAU / 60.0);
    let car = VehicleBlueprint::model3();
    for line in &car.throttle {
        let damping = 2.0 + (0.15 - 2.0) * line.throttle;
        let passed = clutch / (clutch + damping);
        let at_rest = passed * line.throttle * 400.0 * ratio / moved;
        let slope = passed * (rise * line.throttle - damping) * ratio * ratio / moved;
        assert!((line.at_rest - at_rest).abs() < 0.006, "{line:?}: {at_rest}");
        assert!((line.slope - slope).abs() < 0.001, "{line:?}: {slope}");
    }
    assert!((car.full_brake - 4.0 * 1500.0 / radius / moved).abs() < 0.005);
}

#[test]
fn pedals_give_the_acceleration_asked_for() {
    for car in [VehicleBlueprint::model3(), VehicleBlueprint::mkz_2017(), VehicleBlueprint::generic()] {
        for speed in [0.0, 3.0, 8.0, 15.0] {
            for wanted in [-6.0, -2.5, 0.5, 1.5, 3.0] {
                let got = car.acceleration(car.pedals_for(wanted, speed), speed);
                assert!((got - wanted).abs() < 1e-9, "{wanted} at {speed}: {got}");
            }
        }
    }
}

#[test]
fn a_slippery_road_bounds_braking_and_steering_together() {
    let ice = VehicleBlueprint { grip: 1.0, ..VehicleBlueprint::generic() };
    assert_eq!(ice.acceleration(Control { brake: 1.0, ..Control::default() }, 10.0), -1.0);
    assert_eq!(ice.acceleration(Control { throttle: 1.0, ..Control::default() }, 10.0), 1.0);
    // The pedals for less than the grip are those of a dry road.
    let dry = VehicleBlueprint::generic();
    assert_eq!(ice.pedals_for(-0.8, 10.0), dry.pedals_for(-0.8, 10.0));
    for (wheel, speed) in [(0.02, 5.0), (0.3, 5.0), (-0.3, 5.0), (0.5, 20.0), (0.5, 0.5)] {
        let (slip, left) = ice.slip(wheel, speed);
        let lateral = speed * speed * libm::sin(slip) / (ice.wheelbase / 2.0);
        assert!(lateral.abs() <= 1.0 + 1e-12 && lateral * wheel > 0.0, "{wheel} at {speed}: {lateral}");
        assert!((lateral * lateral + left * left - 1.0).abs() < 1e-9);
        let free = dry.slip(wheel, speed).0;
        assert!(slip.abs() <= free.abs() && (lateral.abs() > 0.999 || slip == free));
    }
}

#[test]
fn steering_weakens_with_speed() {
    let car = VehicleBlueprint::model3();
    let full = 70.0_f64.to_radians() * 0.7;
    assert!((car.wheel_angle(1.0, 0.0) - full).abs() < 1e-12);
    assert!((car.wheel_angle(-1.0, 40.0 / 3.6) + full * 0.85).abs() < 1e-12);
    assert!((car.steer_for(0.1, 5.0) * car.wheel_angle(1.0, 5.0) - 0.1).abs() < 1e-12);
}

fn drive(blueprint: &VehicleBlueprint, from: f64, control: Control, ticks: u32) -> VehicleState {
    let start = VehicleState { speed: from, age: 100.0, ..VehicleState::default() };
    (0..ticks).fold(start, |state, _| state.step(control, blueprint, 0.05))
}

#[test]
fn the_turning_circle_follows_the_wheels() {
    let blueprint = VehicleBlueprint { throttle: vec![], full_brake: 0.0, ..VehicleBlueprint::generic() };
    let end = drive(&blueprint, 2.0, Control { steer: 0.5, ..Control::default() }, 20);
    let wheel = blueprint.wheel_angle(0.5, 2.0);
    let slip = libm::atan(libm::tan(wheel) / 2.0);
    let radius = blueprint.wheelbase / 2.0 / libm::sin(slip);
    assert!((end.pose.yaw - 2.0 / radius).abs() < 1e-12, "turns by distance over radius");
    assert!(end.pose.y > 0.0, "a positive steer turns to the left");
}

#[test]
fn braking_takes_v_squared_over_2a() {
    let blueprint = VehicleBlueprint { low_speed_braking: 1.0, ..VehicleBlueprint::generic() };
    let a = blueprint.full_brake * 0.5;
    let end = drive(&blueprint, 12.0, Control { brake: 0.5, ..Control::default() }, 200);
    assert_eq!(end.speed, 0.0);
    let drag = -blueprint.acceleration(Control::default(), 12.0);
    let (long, short) = (144.0 / (2.0 * a) + 0.31, 144.0 / (2.0 * (a + drag)));
    assert!(end.pose.x < long && end.pose.x > short, "{} not in {short}..{long}", end.pose.x);
}

#[test]
fn a_fresh_car_pauses_and_then_drives() {
    let blueprint = VehicleBlueprint { start_up_pause: 1.0, ..VehicleBlueprint::model3() };
    let full = Control { throttle: 1.0, ..Control::default() };
    let mut car = VehicleState::default();
    for _ in 0..20 {
        assert_eq!(car.speed, 0.0);
        car = car.step(full, &blueprint, 0.05);
    }
    car = car.step(full, &blueprint, 0.05);
    assert!(car.speed > 0.18);
}
