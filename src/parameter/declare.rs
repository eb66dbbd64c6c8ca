//! The declaration of parameters.

/// Declares a group of parameters: the struct with its documentation, `serde` and JSON schema, [`Parameters`] and, where all
/// entries have a default, [`Default`].
///
/// An entry reads `/// text`, then `pub name: type = default, "unit", [range], "source";`. The unit of a plain number is `"1"`. Ranges:
/// see [`Range`]; `[choice]` for a [`Choice`], `[group]` for parameters of their own. In a group without defaults an entry reads
/// `pub name: type, "unit", [range], "what holds without it";`, in one that only joins groups `pub name: type;`.
macro_rules! parameters {
    (
        $(#[doc = $about:tt])+
        pub struct $name:ident { $(
            $(#[doc = $text:tt])+
            pub $field:ident: $type:ty = $default:expr, $unit:tt, $range:tt, $source:tt;
        )+ }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        #[schemars(transform = $crate::parameter::write_ranges::<$name>)]
        pub struct $name { $(
            $(#[doc = $text])+
            #[doc = parameter_sentence!($range, $unit, $source, $default)]
            pub $field: $type,
        )+ }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        $crate::parameter::declared! { $name { $($field: $type = stringify!($default), $range, $source, [$($text),+];)+ } }
    };
    (
        $(#[doc = $about:tt])+
        pub struct $name:ident { $(
            $(#[doc = $text:tt])+
            $(#[serde($($serde:tt)+)])?
            pub $field:ident: $type:ty, $unit:tt, $range:tt, $otherwise:tt;
        )+ }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[schemars(transform = $crate::parameter::write_ranges::<$name>)]
        pub struct $name { $(
            $(#[doc = $text])+
            #[doc = parameter_sentence!($range, $unit, $otherwise)]
            $(#[serde($($serde)+)])?
            pub $field: $type,
        )+ }

        $crate::parameter::declared! { $name { $($field: $type = "", $range, $otherwise, [$($text),+];)+ } }
    };
    (
        $(#[doc = $about:tt])+
        pub struct $name:ident { $( $(#[doc = $text:tt])+ pub $field:ident: $type:ty; )+ }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $( $(#[doc = $text])+ pub $field: $type, )+ }

        $crate::parameter::declared! { $name { $($field: $type = "", [group], "", [$($text),+];)+ } }
    };
}

/// The entries and the check of a group.
macro_rules! declared {
    ($name:ident { $($field:ident: $type:ty = $default:expr, $range:tt, $source:tt, [$($text:tt),+];)+ }) => {
        impl $crate::parameter::Parameters for $name {
            const ENTRIES: &'static [$crate::parameter::Parameter] = &[$(
                $crate::parameter::Parameter {
                    name: stringify!($field),
                    text: &[$($text),+],
                    default: $default,
                    source: $source,
                    kind: $crate::parameter::kind!($range, $type),
                },
            )+];

            fn check(&self, at: &str, faults: &mut Vec<$crate::parameter::Fault>) {
                $( $crate::parameter::check!($range, &self.$field, format!("{at}.{}", stringify!($field)), faults); )+
            }
        }
    };
}

/// The [`Kind`] of an entry.
macro_rules! kind {
    ([choice], $type:ty) => {
        $crate::parameter::Kind::Choice
    };
    ([group], $type:ty) => {
        $crate::parameter::Kind::Group(<$type as $crate::parameter::Parameters>::ENTRIES)
    };
    ($range:tt, $type:ty) => {
        $crate::parameter::Kind::Number($crate::parameter::range!($range))
    };
}

/// The check of an entry.
macro_rules! check {
    ([choice], $value:expr, $at:expr, $faults:expr) => {{
        fn all_are_allowed(_: &impl $crate::parameter::Choice) {}
        all_are_allowed($value);
    }};
    ([group], $value:expr, $at:expr, $faults:expr) => {
        $crate::parameter::Parameters::check($value, &$at, $faults)
    };
    ($range:tt, $value:expr, $at:expr, $faults:expr) => {
        $crate::parameter::range!($range).check($value, &$at, $faults)
    };
}

pub(crate) use {check, declared, kind, parameters};
