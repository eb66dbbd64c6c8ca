//! Output quantities described once: name, unit, text and getter come from the field that holds the value.

/// Kind of number that a quantity is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuantityKind {
    /// A floating-point figure.
    Real,
    /// A non-negative whole number.
    Count,
}

/// Value of a quantity in one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuantityValue {
    /// A floating-point figure in the quantity's unit.
    Real(f64),
    /// A non-negative whole number.
    Count(u64),
}

/// One output quantity of the metrics type `T`.
#[derive(Debug, Clone, Copy)]
pub struct Quantity<T: 'static> {
    /// Name of the field: the same in tables, JSON and texts; ends in the unit where there is one.
    pub name: &'static str,
    /// Unit; `1` where there is none.
    pub unit: &'static str,
    /// The field's documentation, line by line as written.
    pub documentation: &'static [&'static str],
    /// Kind of number.
    pub kind: QuantityKind,
    /// Reads the value; `None` where the run does not have it.
    pub value: fn(&T) -> Option<QuantityValue>,
}

impl<T> Quantity<T> {
    /// The documentation as one line.
    pub fn description(&self) -> String {
        let lines: Vec<&str> = self.documentation.iter().map(|line| line.trim()).collect();
        lines.join(" ")
    }
}

/// Types of field that a quantity can have.
pub trait QuantityField: Copy {
    /// Kind of number.
    const KIND: QuantityKind;
    /// The value, if there is one.
    fn value(self) -> Option<QuantityValue>;
}

impl QuantityField for f64 {
    const KIND: QuantityKind = QuantityKind::Real;
    fn value(self) -> Option<QuantityValue> {
        Some(QuantityValue::Real(self))
    }
}

impl QuantityField for Option<f64> {
    const KIND: QuantityKind = QuantityKind::Real;
    fn value(self) -> Option<QuantityValue> {
        self.map(QuantityValue::Real)
    }
}

impl QuantityField for u64 {
    const KIND: QuantityKind = QuantityKind::Count;
    fn value(self) -> Option<QuantityValue> {
        Some(QuantityValue::Count(self))
    }
}

/// Declares a struct of output quantities and its constant `QUANTITIES`, in the order of the fields.
///
/// A field reads `/// text` then `pub name: type => "unit",`.
macro_rules! quantities {
    (
        $(#[doc = $struct_text:literal])+
        pub struct $name:ident {
            $( $(#[doc = $text:literal])+ pub $field:ident: $type:ty => $unit:literal, )+
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
                    value: |metrics| $crate::metrics::QuantityField::value(metrics.$field),
                }, )+
            ];
        }
    };
}

pub(super) use quantities;

#[cfg(test)]
mod tests {
    use super::{QuantityKind, QuantityValue};
    use crate::metrics::{CastingMetrics, HammerMetrics};

    #[test]
    fn names_end_in_the_unit() {
        let all = (HammerMetrics::QUANTITIES.iter().map(|q| (q.name, q.unit)))
            .chain(CastingMetrics::QUANTITIES.iter().map(|q| (q.name, q.unit)));
        for (name, unit) in all {
            let suffix = match unit {
                "1" => continue,
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
            match quantity.name {
                "hit_frequency_hz" => assert_eq!(value, Some(QuantityValue::Real(22.0))),
                "contact_count" => assert_eq!(value, Some(QuantityValue::Count(7))),
                "periodic_blow_count" => assert_eq!(value, Some(QuantityValue::Count(0))),
                "air_used_nl" => assert_eq!(value, Some(QuantityValue::Real(0.0))),
                _ => assert_eq!((value, quantity.kind), (None, QuantityKind::Real)),
            }
            assert!(quantity.description().ends_with('.'), "{}", quantity.name);
        }
    }
}
