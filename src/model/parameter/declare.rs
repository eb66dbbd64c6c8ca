//! The declaration of parameters.

/// Declares a group of parameters: the struct with its documentation, [`Parameters`](super::Parameters) and [`Default`].
///
/// An entry reads `/// text`, then `pub name: type = default, "unit", [range], "source";`, without a default
/// `pub name: type, "unit", [range], "what holds without it";`. The unit of a plain number is `"1"`. Ranges: see
/// [`Range`](super::Range); `[choice]` for a [`Choice`](super::Choice), `[group]` for parameters of their own. Behind a range may
/// stand between which numbers a value usually lies, `[> 0] usual [0.01, 5]`, see [`Usual`](super::Usual).
///
/// A group that begins with `file` is a table of a file and read as it is. Data of a scene may begin with `own { .. }`, fields that
/// are no parameters (names, places, lists). `pub struct Data from Table` also declares the table of a study that states the data:
/// each entry is optional there but the one in `required { .. }`; `typed { .. }` and `typed_last { .. }` are further keys of the table
/// before and behind them, those of a group of their own among them (`with Group`). The order of keys is part of a study's hash. What
/// the data derive beyond `Debug`, `Clone` and `PartialEq` stands before them.
macro_rules! parameters {
    (file $(#[$about:meta])+ pub struct $name:ident { $($entries:tt)+ }) => {
        $crate::parameter::parameters! {
            $(#[$about])+
            #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
            #[serde(default, deny_unknown_fields)]
            #[schemars(transform = $crate::parameter::describe::<$name>)]
            pub struct $name { $($entries)+ }
        }
    };
    ($(#[$attribute:meta])+ pub struct $name:ident {
        $( own { $( $(#[$own_text:meta])+ pub $own:ident: $own_type:ty, )+ } )?
        $(
            $(#[doc = $text:tt])+
            $(#[serde($($serde:tt)+)])?
            pub $field:ident: $type:ty $(= $default:expr)?, $unit:tt, $range:tt $(usual $usual:tt)?, $source:tt;
        )+
    }) => {
        $(#[$attribute])+
        pub struct $name {
            $($( $(#[$own_text])+ pub $own: $own_type, )+)?
            $(
                $(#[doc = $text])+
                #[doc = concat!(parameter_sentence!($range, $unit, $source $(, $default)?), parameter_usual!($unit $(, $usual)?))]
                $(#[serde($($serde)+)])?
                pub $field: $type,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    $($( $own: Default::default(), )+)?
                    $( $field: $crate::parameter::default!($($default)?), )+
                }
            }
        }

        impl $crate::parameter::Parameters for $name {
            const ENTRIES: &'static [$crate::parameter::Parameter] = &[$( $crate::parameter::Parameter {
                name: stringify!($field),
                text: &[$($text),+],
                values: concat!(parameter_sentence!($range, $unit, $source $(, $default)?), parameter_usual!($unit $(, $usual)?)),
                source: $source,
                kind: $crate::parameter::kind!($range, $type),
            }, )+];

            fn check(&self, at: &str, faults: &mut Vec<$crate::parameter::Fault>) {
                $( $crate::parameter::check!($range, &self.$field, $crate::parameter::key(at, stringify!($field)), faults); )+
            }

            fn unusual(&self, at: &str, remarks: &mut Vec<$crate::parameter::Fault>) {
                let path = |field| $crate::parameter::key(at, field);
                $( $crate::parameter::unusual!(
                    ($range, $unit $(, $usual)?), &self.$field, path(stringify!($field)), remarks
                ); )+
                // Where no entry has usual values.
                let _ = (path, remarks);
            }
        }
    };
    ($(#[doc = $about:tt])+ $(#[derive($($derived:ident),+)])?
    pub struct $name:ident from $table:ident $(with $group:ident)? {
        $( own { $($own:tt)+ } )?
        $( typed { $($typed:tt)+ } )?
        $( required {
            $(#[doc = $text_1:tt])+
            pub $field_1:ident: $type_1:ty, $unit_1:tt, $range_1:tt $(usual $usual_1:tt)?, $source_1:tt;
        } )?
        $(
            $(#[doc = $text:tt])+
            pub $field:ident: $type:ty $(= $default:expr)?, $unit:tt, $range:tt $(usual $usual:tt)?, $source:tt;
        )+
        $( typed_last { $($typed_last:tt)+ } )?
    }) => {
        $crate::parameter::parameters! {
            $(#[doc = $about])+
            #[derive(Debug, Clone, PartialEq $($(, $derived)+)?)]
            pub struct $name {
                $( own { $($own)+ } )?
                $( $(#[doc = $text_1])+ pub $field_1: $type_1, $unit_1, $range_1 $(usual $usual_1)?, $source_1; )?
                $( $(#[doc = $text])+ pub $field: $type $(= $default)?, $unit, $range $(usual $usual)?, $source; )+
            }
        }

        $(#[doc = $about])+
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[schemars(transform = $crate::parameter::describe::<$name>)]
        $( #[schemars(transform = $crate::parameter::describe::<$group>)] )?
        pub struct $table {
            $( $($typed)+ )?
            $( $(#[doc = $text_1])+ pub $field_1: $type_1, )?
            $( $(#[doc = $text])+ #[serde(skip_serializing_if = "Option::is_none")] pub $field: Option<$type>, )+
            $( $($typed_last)+ )?
        }

        impl $table {
            /// Returns the values of the table, with `base` for all others.
            pub fn over(&self, base: $name) -> $name {
                let mut all = base;
                $( all.$field_1.clone_from(&self.$field_1); )?
                $( if let Some(value) = &self.$field { all.$field.clone_from(value); } )+
                all
            }
        }
    };
}

/// Default of an entry; otherwise the default of its type.
#[rustfmt::skip]
macro_rules! default {
    ($default:expr) => { $default };
    () => { Default::default() };
}

/// The [`ParameterKind`](super::Kind) of an entry.
#[rustfmt::skip]
macro_rules! kind {
    ([choice], $type:ty) => { $crate::parameter::ParameterKind::Choice };
    ([group], $type:ty) => { $crate::parameter::ParameterKind::Group(<$type as $crate::parameter::Parameters>::ENTRIES) };
    ($range:tt, $type:ty) => { $crate::parameter::ParameterKind::Number($crate::parameter::range!($range)) };
}

/// The check of an entry.
#[rustfmt::skip]
macro_rules! check {
    ([choice], $value:expr, $at:expr, $faults:expr) => { $crate::parameter::Choice::check($value) };
    ([group], $value:expr, $at:expr, $faults:expr) => { $crate::parameter::Parameters::check($value, &$at, $faults) };
    ($range:tt, $value:expr, $at:expr, $faults:expr) => { $crate::parameter::range!($range).check($value, &$at, $faults) };
}

/// The look at an entry's usual values.
#[rustfmt::skip]
macro_rules! unusual {
    (([group], $unit:tt), $value:expr, $at:expr, $remarks:expr) => {
        $crate::parameter::Parameters::unusual($value, &$at, $remarks)
    };
    (($range:tt, $unit:tt), $value:expr, $at:expr, $remarks:expr) => {};
    (($range:tt, $unit:tt, [$low:literal, $high:literal]), $value:expr, $at:expr, $remarks:expr) => {
        $crate::parameter::Usual { low: $low as f64, high: $high as f64, unit: $unit }.look($value, &$at, $remarks)
    };
}

pub(crate) use {check, default, kind, parameters, unusual};
