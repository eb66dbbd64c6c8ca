//! Closed sets of names.

/// Declares a closed set of names: an enum, each of its values with its name in tables, files, JSON and texts and on the command
/// line, which is so stated once.
///
/// Besides the enum, which derives serde's `Serialize` at least, there are `ALL`, all values in this order, `name`, and
/// [`QuantityField`](crate::QuantityField): a category in tables.
#[macro_export]
macro_rules! named {
    (
        $(#[$about:meta])+
        pub enum $type:ident { $( $(#[$text:meta])+ $value:ident = $name:literal, )+ }
    ) => {
        $(#[$about])+
        pub enum $type { $( $(#[$text])+ #[serde(rename = $name)] $value, )+ }

        impl $type {
            /// All, in their order.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$value),+];

            /// Name in files.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$value => $name,)+ }
            }
        }

        impl $crate::QuantityField for $type {
            const KIND: $crate::Kind = $crate::Kind::Category;

            fn value(&self) -> $crate::Cell<'_> {
                Some($crate::Value::Text(self.name()))
            }
        }
    };
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};

    use crate::{Kind, QuantityField, Value};

    named! {
        /// Two names.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub enum Two {
            /// The one.
            One = "the_one",
            /// The other.
            Other = "other",
        }
    }

    #[test]
    fn a_name_is_the_same_everywhere() {
        for value in Two::ALL {
            let json = serde_json::to_string(&value).expect("a name");
            assert_eq!(json, format!("\"{}\"", value.name()));
            assert_eq!(serde_json::from_str::<Two>(&json).expect("its name"), value);
            assert_eq!((Two::KIND, value.value()), (Kind::Category, Some(Value::Text(value.name()))));
        }
        assert_eq!(Two::ALL, [Two::One, Two::Other]);
    }
}
