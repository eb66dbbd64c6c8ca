//! Filters and densities against scipy's for one signal (`benches/signal_reference.py` computed them).

use decore_statistics::signal::{Butterworth, SignalError, welch};
use serde_json::Value;

const MOST_ERROR: f64 = 1e-10;

fn reference() -> Value {
    serde_json::from_str(include_str!("../data/signal_references.json")).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).unwrap()
}

fn worst(ours: &[f64], theirs: &[f64]) -> f64 {
    assert_eq!(ours.len(), theirs.len());
    ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn val_low_pass_equals_scipy() {
    let reference = reference();
    let samples = numbers(&reference["samples"]);
    for one in reference["filters"].as_array().unwrap() {
        let order = one["order"].as_u64().unwrap() as usize;
        let (cutoff_hz, rate_hz) = (one["cutoff_hz"].as_f64().unwrap(), one["rate_hz"].as_f64().unwrap());
        let name = format!("order {order}, {cutoff_hz} of {rate_hz} Hz");
        let filter = Butterworth::low_pass(order, cutoff_hz, rate_hz).unwrap();
        let sos: Vec<Vec<f64>> = serde_json::from_value(one["sos"].clone()).unwrap();
        assert_eq!(filter.sections().len(), sos.len(), "{name}");
        for (section, theirs) in filter.sections().iter().zip(&sos) {
            let ours = [&section.b[..], &[1.0], &section.a[..]].concat();
            let error = worst(&ours, theirs);
            assert!(error < MOST_ERROR, "{name}: {ours:?}, scipy {theirs:?}");
        }
        let error = worst(&filter.zero_phase(&samples).unwrap(), &numbers(&one["filtered"]));
        assert!(error < MOST_ERROR, "{name}: filtered signals differ by {error:e}");
    }
}

#[test]
fn val_welch_equals_scipy() {
    let reference = reference();
    let samples = numbers(&reference["samples"]);
    for one in reference["densities"].as_array().unwrap() {
        let (rate_hz, segment) = (one["rate_hz"].as_f64().unwrap(), one["segment"].as_u64().unwrap() as usize);
        let density = welch(&samples, rate_hz, segment).unwrap();
        assert!((density.resolution_hz - one["resolution_hz"].as_f64().unwrap()).abs() < MOST_ERROR);
        let error = worst(&density.power, &numbers(&one["power"]));
        assert!(error < MOST_ERROR, "{segment} samples at {rate_hz} Hz: {error:e}");
    }
}

#[test]
fn filters_that_cannot_be_are_refused() {
    for (order, cutoff_hz, rate_hz) in [
        (0, 10.0, 100.0),
        (21, 10.0, 100.0),
        (2, 50.0, 100.0),
        (2, 0.0, 100.0),
        (2, f64::NAN, 100.0),
        (2, 1.0, f64::INFINITY),
    ] {
        let refused = Butterworth::low_pass(order, cutoff_hz, rate_hz);
        assert!(matches!(refused, Err(SignalError::Filter { .. })), "{order}, {cutoff_hz}, {rate_hz}");
    }
    let filter = Butterworth::low_pass(4, 10.0, 100.0).unwrap();
    assert_eq!(filter.padding(), 15);
    assert!(matches!(filter.zero_phase(&[1.0; 15]), Err(SignalError::Short { samples: 15, least: 16, .. })));
    let level = filter.zero_phase(&[2.5; 16]).unwrap();
    assert!(worst(&level, &[2.5; 16]) < 1e-12, "{level:?}");
}
