//! The declaration of parameters.

/// Declares a group of parameters: the struct with its documentation, [`Parameters`](super::Parameters) and [`Default`].
///
/// An entry reads `/// text`, then `pub name: type = default, "unit", [range], "source";`, without a default
/// `pub name: type, "unit", [range], "what holds without it";`. The unit of a plain number is `"1"`. Ranges: see
/// [`Range`](super::Range); `[choice]` for a [`Choice`](super::Choice), `[group]` for parameters of their own. Groups are
///
/// - part of a file, read as they are: all entries have defaults, or none has;
/// - groups of groups, `pub name: type;`;
/// - data of a scene: they begin with `own { .. }`, fields that are no parameters (names, places, lists);
/// - data of a scene with the table of a study that states them, `pub struct Data from Table`: each entry is optional there, and
///   `typed { .. }` are further keys of the table.
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
        #[schemars(transform = $crate::parameter::describe::<$name>)]
        pub struct $name { $(
            $(#[doc = $text])+
            #[doc = parameter_sentence!($range, $unit, $source, $default)]
            pub $field: $type,
        )+ }

        $crate::parameter::default! { $name { $($field = $default;)+ } }
        $crate::parameter::declared! { $name { $($field: $type = ($default), $unit, $range, $source, [$($text),+];)+ } }
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
        #[schemars(transform = $crate::parameter::describe::<$name>)]
        pub struct $name { $(
            $(#[doc = $text])+
            #[doc = parameter_sentence!($range, $unit, $otherwise)]
            $(#[serde($($serde)+)])?
            pub $field: $type,
        )+ }

        $crate::parameter::declared! { $name { $($field: $type = (), $unit, $range, $otherwise, [$($text),+];)+ } }
    };
    (
        $(#[doc = $about:tt])+
        pub struct $name:ident { $( $(#[doc = $text:tt])+ pub $field:ident: $type:ty; )+ }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $( $(#[doc = $text])+ pub $field: $type, )+ }

        $crate::parameter::declared! { $name { $($field: $type = (), "", [group], "", [$($text),+];)+ } }
    };
    (
        $(#[doc = $about:tt])+
        pub struct $name:ident {
            own { $( $(#[doc = $own_text:tt])+ pub $own:ident: $own_type:ty, )+ }
            $(
                $(#[doc = $text:tt])+
                pub $field:ident: $type:ty $(= $default:expr)?, $unit:tt, $range:tt, $source:tt;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, PartialEq)]
        pub struct $name {
            $( $(#[doc = $own_text])+ pub $own: $own_type, )+
            $(
                $(#[doc = $text])+
                #[doc = parameter_sentence!($range, $unit, $source $(, $default)?)]
                pub $field: $type,
            )+
        }

        $crate::parameter::default! { $name { $($own;)+ $($field $(= $default)?;)+ } }
        $crate::parameter::declared! { $name { $($field: $type = ($($default)?), $unit, $range, $source, [$($text),+];)+ } }
    };
    (
        $(#[doc = $about:tt])+
        pub struct $name:ident from $table:ident {
            typed { $($typed:tt)+ }
            $(
                $(#[doc = $text:tt])+
                pub $field:ident: $type:ty = $default:expr, $unit:tt, $range:tt, $source:tt;
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name { $(
            $(#[doc = $text])+
            #[doc = parameter_sentence!($range, $unit, $source, $default)]
            pub $field: $type,
        )+ }

        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields)]
        #[schemars(transform = $crate::parameter::describe::<$name>)]
        pub struct $table {
            $($typed)+
            $(
                $(#[doc = $text])+
                #[doc = parameter_sentence!($range, $unit, $source, $default)]
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $field: Option<$type>,
            )+
        }

        impl From<$name> for $table {
            fn from(all: $name) -> Self {
                Self { $($field: Some(all.$field),)+ ..Self::default() }
            }
        }

        impl $table {
            /// What the table states, the rest from `base`.
            pub fn over(&self, base: $name) -> $name {
                $name { $($field: self.$field.unwrap_or(base.$field)),+ }
            }
        }

        $crate::parameter::default! { $name { $($field = $default;)+ } }
        $crate::parameter::declared! { $name { $($field: $type = ($default), $unit, $range, $source, [$($text),+];)+ } }
    };
}

/// The defaults of a group; what has none of its own has that of its type.
macro_rules! default {
    (value $default:expr) => { $default };
    (value) => { Default::default() };
    ($name:ident { $($field:ident $(= $default:expr)?;)+ }) => {
        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $crate::parameter::default!(value $($default)?)),+ }
            }
        }
    };
}

/// The entries and the check of a group.
macro_rules! declared {
    ($name:ident { $(
        $field:ident: $type:ty = ($($default:expr)?), $unit:tt, $range:tt, $source:tt, [$($text:tt),+];
    )+ }) => {
        impl $crate::parameter::Parameters for $name {
            const ENTRIES: &'static [$crate::parameter::Parameter] = &[$(
                $crate::parameter::Parameter {
                    name: stringify!($field),
                    text: &[$($text),+],
                    values: parameter_sentence!($range, $unit, $source $(, $default)?),
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

/// The [`Kind`](super::Kind) of an entry.
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

pub(crate) use {check, declared, default, kind, parameters};
