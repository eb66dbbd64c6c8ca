//! Lengths of the moves of a Morris design.

use super::table::FactorColumn;
use decore_statistics::analysis::Reach;
use decore_study::FactorOutline;

/// Values of a factor for the length of its moves, and its whole range. For whole numbers and lists these are the values themselves,
/// because rounding changes their moves; on a logarithmic scale the logarithms.
pub(super) fn moves(factor: &FactorColumn, outline: Option<&FactorOutline>, values: Vec<f64>) -> (Vec<f64>, Reach) {
    let Some(outline) = outline.filter(|_| !factor.nominal) else {
        return (values, if factor.nominal { Reach::Names } else { Reach::Grid });
    };
    let listed: Vec<f64> = outline.values.iter().filter_map(|value| value.number()).collect();
    let ends = match (listed.is_empty(), outline.range) {
        (false, _) => [
            listed.iter().copied().fold(f64::INFINITY, f64::min),
            listed.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        ],
        // A range of any numbers that has only whole ones moves by the same either way.
        (true, Some([low, high])) if values.iter().all(|value| value.fract() == 0.0) => [low.ceil(), high.floor()],
        _ => return (values, Reach::Grid),
    };
    let logarithmic = outline.logarithmic && listed.is_empty() && ends[0] > 0.0;
    let measured = |value: f64| if logarithmic { value.ln() } else { value };
    let reach = measured(ends[1]) - measured(ends[0]);
    if reach > 0.0 { (values.into_iter().map(measured).collect(), Reach::Values(reach)) } else { (values, Reach::Grid) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decore_quantity::Value;

    #[test]
    fn whole_numbers_and_lists_have_ranges_of_their_own() {
        let reach = |values: &[f64], listed: &[f64], range: Option<[f64; 2]>, logarithmic: bool| {
            let outline = FactorOutline {
                name: "x".into(),
                derived: false,
                expression: None,
                drives: Vec::new(),
                links: Vec::new(),
                values: listed.iter().map(|value| Value::Real(*value)).collect(),
                range,
                logarithmic,
            };
            let factor = FactorColumn { name: "x".into(), values: values.to_vec(), nominal: false, names: Vec::new() };
            moves(&factor, Some(&outline), values.to_vec()).1
        };
        assert_eq!(reach(&[1.0, 4.0], &[], Some([1.0, 5.0]), false), Reach::Values(4.0));
        assert_eq!(reach(&[1.5, 2.5], &[1.5, 2.5, 4.5], None, false), Reach::Values(3.0));
        assert_eq!(reach(&[0.4, 0.8], &[], Some([0.4, 1.0]), false), Reach::Grid);
        assert_eq!(reach(&[1.0, 10.0], &[], Some([1.0, 100.0]), true), Reach::Values(100.0_f64.ln()));
    }
}
