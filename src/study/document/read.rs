//! Reads a tree of values as a type; errors contain the key.

use std::fmt;

use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, SeqAccess, Unexpected, Visitor};
use toml::Value;

/// Reads a tree of values; the error is the key's path and the message.
pub(crate) fn read_tree<T: serde::de::DeserializeOwned>(value: Value) -> Result<T, (String, String)> {
    T::deserialize(Tree(value)).map_err(|refused| {
        // A fault of the whole has no key.
        let path = if refused.path.is_empty() { ".".to_owned() } else { refused.path };
        (path, refused.message)
    })
}

/// Reason why a tree does not have a type.
#[derive(Debug)]
struct Refused {
    /// Path of the value at fault from where its reader stands: keys with dots between them, positions in brackets.
    path: String,
    message: String,
}

impl Refused {
    /// The same, seen from the table that has the value under `key`.
    fn under(mut self, key: &str) -> Self {
        let between = if self.path.is_empty() || self.path.starts_with('[') { "" } else { "." };
        self.path.insert_str(0, between);
        self.path.insert_str(0, key);
        self
    }

    /// The same, seen from the array that has the value at `position`.
    fn at(self, position: usize) -> Self {
        self.under(&format!("[{position}]"))
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Refused {}

impl serde::de::Error for Refused {
    fn custom<M: fmt::Display>(message: M) -> Self {
        Self { path: String::new(), message: message.to_string() }
    }
}

/// A tree of values, which a type reads itself from.
///
/// A [`Value`] would work too, but its code for each of a study's tables would be three times as large, because it may also be an array or
/// a date with its parts. Here a struct is a table and a date its text.
struct Tree(Value);

impl Tree {
    /// Error of a visitor that expects something else.
    fn refused<'de, V: Visitor<'de>>(&self, visitor: &V) -> Refused {
        let date;
        let found = match &self.0 {
            Value::String(text) => Unexpected::Str(text),
            Value::Integer(number) => Unexpected::Signed(*number),
            Value::Float(number) => Unexpected::Float(*number),
            Value::Boolean(flag) => Unexpected::Bool(*flag),
            Value::Datetime(found) => {
                date = format!("date `{found}`");
                Unexpected::Other(&date)
            }
            Value::Array(_) => Unexpected::Seq,
            Value::Table(_) => Unexpected::Map,
        };
        serde::de::Error::invalid_type(found, visitor)
    }
}

impl<'de> Deserializer<'de> for Tree {
    type Error = Refused;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        match self.0 {
            Value::String(text) => visitor.visit_string(text),
            Value::Integer(number) => visitor.visit_i64(number),
            Value::Float(number) => visitor.visit_f64(number),
            Value::Boolean(flag) => visitor.visit_bool(flag),
            Value::Datetime(_) => Err(self.refused(&visitor)),
            Value::Array(_) => self.deserialize_seq(visitor),
            Value::Table(_) => self.deserialize_map(visitor),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        let Value::Array(entries) = self.0 else { return Err(self.refused(&visitor)) };
        let length = entries.len();
        let mut entries = Entries(entries.into_iter().enumerate());
        let value = visitor.visit_seq(&mut entries)?;
        match entries.0.len() {
            0 => Ok(value),
            left => {
                let expected = format!("{} elements in sequence", length - left);
                Err(serde::de::Error::invalid_length(length, &expected.as_str()))
            }
        }
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        let Value::Table(entries) = self.0 else { return Err(self.refused(&visitor)) };
        visitor.visit_map(Pairs { left: entries.into_iter(), present: None })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        self.deserialize_map(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _length: usize, visitor: V) -> Result<V::Value, Refused> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _name: &'static str, visitor: V) -> Result<V::Value, Refused> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        match self.0 {
            Value::String(text) => visitor.visit_enum(text.into_deserializer()),
            _ => Err(self.refused(&visitor)),
        }
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct tuple_struct
        identifier ignored_any
    }
}

/// The entries of an array, with their positions.
struct Entries(std::iter::Enumerate<std::vec::IntoIter<Value>>);

impl<'de> SeqAccess<'de> for Entries {
    type Error = Refused;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Refused> {
        let Some((position, value)) = self.0.next() else { return Ok(None) };
        seed.deserialize(Tree(value)).map(Some).map_err(|refused| refused.at(position))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// The keys of a table with their values.
struct Pairs {
    left: toml::map::IntoIter<String, Value>,
    /// The key read last, and its value.
    present: Option<(String, Value)>,
}

impl<'de> MapAccess<'de> for Pairs {
    type Error = Refused;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Refused> {
        let Some((key, value)) = self.left.next() else { return Ok(None) };
        let name: StrDeserializer<'_, Refused> = key.as_str().into_deserializer();
        let read = seed.deserialize(name).map_err(|refused| refused.under(&key))?;
        self.present = Some((key, value));
        Ok(Some(read))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Refused> {
        let Some((key, value)) = self.present.take() else {
            return Err(serde::de::Error::custom("a value was asked for before its key"));
        };
        seed.deserialize(Tree(value)).map_err(|refused| refused.under(&key))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.left.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        pair: [f64; 2],
        word: Option<Word>,
    }

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Word {
        One,
    }

    #[derive(Debug, PartialEq, serde::Deserialize)]
    struct Outer {
        inner: Vec<Inner>,
    }

    fn read(text: &str) -> Result<Outer, (String, String)> {
        read_tree(Value::Table(toml::from_str(text).unwrap()))
    }

    #[test]
    fn a_tree_is_read_as_its_type() {
        let found = read("[[inner]]\npair = [1, 2.5]\nword = 'one'\n[[inner]]\npair = [inf, 0.0]").unwrap();
        let first = Inner { pair: [1.0, 2.5], word: Some(Word::One) };
        assert_eq!(found, Outer { inner: vec![first, Inner { pair: [f64::INFINITY, 0.0], word: None }] });
    }

    #[test]
    fn what_is_no_such_type_is_refused_at_its_key() {
        for (text, key, message) in [
            ("inner = [{ pair = [1] }]", "inner[0].pair", "invalid length 1, expected an array of length 2"),
            ("inner = [{ pair = [1, 2, 3] }]", "inner[0].pair", "invalid length 3, expected 2 elements in sequence"),
            ("inner = [{ pair = [1, '2'] }]", "inner[0].pair[1]", "invalid type: string \"2\", expected f64"),
            ("inner = [[[1, 2], 'one']]", "inner[0]", "invalid type: sequence, expected struct Inner"),
            ("inner = [1979-05-27]", "inner[0]", "invalid type: date `1979-05-27`, expected struct Inner"),
            ("inner = { a = 1 }", "inner", "invalid type: map, expected a sequence"),
            ("inner = [{ pair = [1, 2], word = 3 }]", "inner[0].word", "invalid type: integer `3`, expected enum Word"),
            ("inner = [{ pear = 1 }]", "inner[0].pear", "unknown field `pear`, expected `pair` or `word`"),
            ("inner = [{ word = 'one' }]", "inner[0]", "missing field `pair`"),
            ("outer = 1", ".", "missing field `inner`"),
        ] {
            let (at, why) = read(text).unwrap_err();
            assert_eq!((at.as_str(), why.as_str()), (key, message), "{text}");
        }
    }
}
