//! Output quantities described once: name, unit, text and getter come from the field that holds the value.

use super::bytes::put_cell;
use super::value::{Cell, Kind, Value};

/// One output quantity of the type `T`.
#[derive(Debug, Clone, Copy)]
pub struct Quantity<T: 'static> {
    /// Name of the field: the same in tables, JSON and texts; ends in the unit where there is one.
    pub name: &'static str,
    /// Unit; `1` where there is none, empty for names.
    pub unit: &'static str,
    /// The field's documentation, line by line as written.
    pub documentation: &'static [&'static str],
    /// Kind of value.
    pub kind: Kind,
    /// Short name for tables that are narrow, in which only quantities that have one are shown.
    pub heading: Option<&'static str>,
    /// Whether it is a main output: one whose scatter over twins is reported.
    pub main: bool,
    /// Whether small values are better; large ones otherwise.
    pub less: bool,
    /// Reads the value; `None` where the run does not have it.
    pub value: for<'a> fn(&'a T) -> Cell<'a>,
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
    const KIND: Kind;
    /// The value, if there is one.
    fn value(&self) -> Cell<'_>;
    /// Appends it as [`put_cell`](super::put_cell) does. A call, as the code of all quantities together must be short.
    #[inline(never)]
    fn put(&self, bytes: &mut Vec<u8>) {
        put_cell(bytes, self.value());
    }
}

impl QuantityField for f64 {
    const KIND: Kind = Kind::Real;
    fn value(&self) -> Cell<'_> {
        Some(Value::Real(*self))
    }
}

impl QuantityField for u64 {
    const KIND: Kind = Kind::Count;
    fn value(&self) -> Cell<'_> {
        Some(Value::Count(*self))
    }
}

impl QuantityField for usize {
    const KIND: Kind = Kind::Count;
    fn value(&self) -> Cell<'_> {
        Some(Value::Count(*self as u64))
    }
}

impl QuantityField for String {
    const KIND: Kind = Kind::Text;
    fn value(&self) -> Cell<'_> {
        Some(Value::Text(self))
    }
}

impl<F: QuantityField> QuantityField for Option<F> {
    const KIND: Kind = F::KIND;
    fn value(&self) -> Cell<'_> {
        self.as_ref().and_then(QuantityField::value)
    }
}

/// Declares a struct of output quantities: per quantity a constant of the struct with the field's name, which is how code names
/// it, and all of them in the order of the fields as the constant `QUANTITIES`.
///
/// A field reads `/// text` then `pub name: type => "unit",`, or `=> "unit" ("heading")` with a short name for narrow tables, or
/// `=> "unit" main` for a main output; with `[less]` behind, small values are better. A field without `=>` is no quantity.
#[macro_export]
macro_rules! quantities {
    (
        $(#[$attribute:meta])+
        pub struct $name:ident {
            $( $(#[doc = $text:literal])+ $(#[serde($($serde:tt)+)])? pub $field:ident: $type:ty
                $(=> $unit:literal $(($heading:literal))? $($main:ident)? $([$less:ident])?)?, )+
        }
    ) => {
        $(#[$attribute])+
        pub struct $name {
            $( $(#[doc = $text])+ $(#[serde($($serde)+)])? pub $field: $type, )+
        }

        // A quantity has the name of its field: the compiler then holds all who name it to it.
        #[allow(non_upper_case_globals)]
        impl $name {
            /// All quantities, in the order of the fields.
            pub const QUANTITIES: &'static [$crate::Quantity<Self>] =
                &[$($($crate::Quantity { unit: $unit, ..Self::$field },)?)+];

            /// Appends the values of all quantities, in their order, as [`put_cell`]($crate::put_cell) does.
            pub fn put_cells(&self, bytes: &mut Vec<u8>) {
                $( $crate::quantities! { @put self bytes $field $($unit)? } )+
            }

            $( $crate::quantities! {
                @one $field: $type, [$($text)+] $($unit [$($heading)?] [$($main)?] [$($less)?])?
            } )+
        }
    };
    (@put $of:ident $bytes:ident $field:ident) => {};
    (@put $of:ident $bytes:ident $field:ident $unit:literal) => {
        $crate::QuantityField::put(&$of.$field, $bytes);
    };
    (@one $field:ident: $type:ty, [$($text:literal)+]) => {};
    (@one $field:ident: $type:ty, [$($text:literal)+] $unit:literal [$($heading:literal)?] [$($main:ident)?]
        [$($less:ident)?]) => {
        $(#[doc = $text])+
        pub const $field: $crate::Quantity<Self> = $crate::Quantity {
            name: stringify!($field),
            unit: $unit,
            documentation: &[$($text),+],
            kind: <$type as $crate::QuantityField>::KIND,
            heading: $crate::first(&[$($heading)?]),
            main: $crate::first(&[$(stringify!($main))?]).is_some(),
            less: $crate::first(&[$(stringify!($less))?]).is_some(),
            value: |of| $crate::QuantityField::value(&of.$field),
        };
    };
}

/// The first of what may be there: a mark that `quantities!` read.
pub const fn first(marks: &[&'static str]) -> Option<&'static str> {
    match marks {
        [first, ..] => Some(first),
        [] => None,
    }
}
