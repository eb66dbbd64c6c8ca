//! Output quantities described once: name, unit, text and getter come from the field that holds the value.

/// Kind of value that a quantity has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuantityKind {
    /// A floating-point figure.
    Real,
    /// A non-negative whole number.
    Count,
    /// A name.
    Text,
}

/// Value of a quantity in one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuantityValue<'a> {
    /// A floating-point figure in the quantity's unit.
    Real(f64),
    /// A non-negative whole number.
    Count(u64),
    /// A name.
    Text(&'a str),
}

impl QuantityValue<'_> {
    /// The value as a floating-point number; `None` for a name.
    pub fn number(self) -> Option<f64> {
        match self {
            Self::Real(value) => Some(value),
            Self::Count(count) => Some(count as f64),
            Self::Text(_) => None,
        }
    }
}

/// One output quantity of the metrics type `T`.
#[derive(Debug, Clone, Copy)]
pub struct Quantity<T: 'static> {
    /// Name of the field: the same in tables, JSON and texts; ends in the unit where there is one.
    pub name: &'static str,
    /// Unit; `1` where there is none, empty for names.
    pub unit: &'static str,
    /// The field's documentation, line by line as written.
    pub documentation: &'static [&'static str],
    /// Kind of value.
    pub kind: QuantityKind,
    /// Whether it is a main output: one whose scatter over twins is reported.
    pub main: bool,
    /// Reads the value; `None` where the run does not have it.
    pub value: for<'a> fn(&'a T) -> Option<QuantityValue<'a>>,
}

impl<T> Quantity<T> {
    /// The documentation as one line.
    pub fn description(&self) -> String {
        let lines: Vec<&str> = self.documentation.iter().map(|line| line.trim()).collect();
        lines.join(" ")
    }
}

/// Types of field that a quantity can have.
pub trait QuantityField {
    /// Kind of value.
    const KIND: QuantityKind;
    /// The value, if there is one.
    fn value(&self) -> Option<QuantityValue<'_>>;
}

impl QuantityField for f64 {
    const KIND: QuantityKind = QuantityKind::Real;
    fn value(&self) -> Option<QuantityValue<'_>> {
        Some(QuantityValue::Real(*self))
    }
}

impl QuantityField for u64 {
    const KIND: QuantityKind = QuantityKind::Count;
    fn value(&self) -> Option<QuantityValue<'_>> {
        Some(QuantityValue::Count(*self))
    }
}

impl QuantityField for String {
    const KIND: QuantityKind = QuantityKind::Text;
    fn value(&self) -> Option<QuantityValue<'_>> {
        Some(QuantityValue::Text(self))
    }
}

impl<F: QuantityField> QuantityField for Option<F> {
    const KIND: QuantityKind = F::KIND;
    fn value(&self) -> Option<QuantityValue<'_>> {
        self.as_ref().and_then(QuantityField::value)
    }
}

/// Declares a struct of output quantities and its constant `QUANTITIES`, in the order of the fields.
///
/// A field reads `/// text` then `pub name: type => "unit",`, or `=> "unit" main,` for a main output.
macro_rules! quantities {
    (
        $(#[doc = $struct_text:literal])+
        pub struct $name:ident {
            $( $(#[doc = $text:literal])+ pub $field:ident: $type:ty => $unit:literal $($main:ident)?, )+
        }
    ) => {
        $(#[doc = $struct_text])+
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
        pub struct $name {
            $( $(#[doc = $text])+ pub $field: $type, )+
        }

        impl $name {
            /// All quantities, in the order of the fields.
            pub const QUANTITIES: &'static [$crate::metrics::Quantity<$name>] = &[
                $( $crate::metrics::Quantity {
                    name: stringify!($field),
                    unit: $unit,
                    documentation: &[$($text),+],
                    kind: <$type as $crate::metrics::QuantityField>::KIND,
                    main: $crate::metrics::quantity::is_main(&[$(stringify!($main))?]),
                    value: |metrics| $crate::metrics::QuantityField::value(&metrics.$field),
                }, )+
            ];
        }
    };
}

pub(super) use quantities;

/// Whether a field was marked.
pub(super) const fn is_main(marks: &[&str]) -> bool {
    !marks.is_empty()
}

#[cfg(test)]
mod tests {
    use super::{QuantityKind, QuantityValue};
    use crate::metrics::{CastingMetrics, HammerMetrics, RunTotals};

    #[test]
    fn names_end_in_the_unit() {
        let all = (HammerMetrics::QUANTITIES.iter().map(|q| (q.name, q.unit, q.kind)))
            .chain(CastingMetrics::QUANTITIES.iter().map(|q| (q.name, q.unit, q.kind)))
            .chain(RunTotals::QUANTITIES.iter().map(|q| (q.name, q.unit, q.kind)));
        for (name, unit, kind) in all {
            assert_eq!(unit.is_empty(), kind == QuantityKind::Text, "{name}");
            let suffix = match unit {
                "1" | "" => continue,
                "s" => "_s",
                "J" => "_j",
                "N" => "_n",
                "N s" => "_n_s",
                "m/s" => "_m_s",
                "Hz" => "_hz",
                "NL" => "_nl",
                other => panic!("unit {other} of {name} has no suffix here"),
            };
            assert!(name.ends_with(suffix), "{name} [{unit}]");
        }
    }

    #[test]
    fn getters_read_their_own_field() {
        let metrics = HammerMetrics { hit_frequency_hz: Some(22.0), contact_count: 7, ..HammerMetrics::default() };
        for quantity in HammerMetrics::QUANTITIES {
            let value = (quantity.value)(&metrics);
            match (quantity.name, quantity.kind) {
                ("hit_frequency_hz", _) => assert_eq!(value, Some(QuantityValue::Real(22.0))),
                ("contact_count", _) => assert_eq!(value, Some(QuantityValue::Count(7))),
                ("percussion", _) => assert_eq!(value, Some(QuantityValue::Text("none"))),
                ("air_used_nl" | "delivered_work_j" | "delivered_impulse_n_s", _) => {
                    assert_eq!(value, Some(QuantityValue::Real(0.0)));
                }
                ("percussion_period", _) => assert_eq!(value, None),
                (_, QuantityKind::Count) => assert_eq!(value, Some(QuantityValue::Count(0))),
                _ => assert_eq!((value, quantity.kind), (None, QuantityKind::Real), "{}", quantity.name),
            }
            assert!(quantity.description().ends_with('.'), "{}", quantity.name);
        }
        let main: Vec<&str> = CastingMetrics::QUANTITIES.iter().filter(|q| q.main).map(|q| q.name).collect();
        assert_eq!(main, ["peak_velocity_m_s", "peak_point_velocity_m_s"]);
    }
}
