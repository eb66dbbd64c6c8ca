//! A tree of values read as a type, with the key at fault.

use serde::de::value::{Error, MapDeserializer, SeqDeserializer};
use serde::de::{Deserializer, Error as _, IntoDeserializer, Unexpected, Visitor};
use toml::Value;

/// Reads a tree of values; the error is the key's path and the message.
pub(in crate::study) fn read_tree<T: serde::de::DeserializeOwned>(value: Value) -> Result<T, (String, String)> {
    serde_path_to_error::deserialize(Tree(value)).map_err(|error| {
        let key = error.path().to_string();
        (key, error.into_inner().to_string())
    })
}

/// A tree of values, which a type reads itself from.
///
/// A [`Value`] would do, but reads a table three times over, for it may also be an array of what the keys hold, or a date with its
/// parts: code for all of them is made of each of a study's tables. Here a struct is a table and a date its text.
struct Tree(Value);

impl Tree {
    /// That a visitor expects something else.
    fn refused<'de, V: Visitor<'de>>(&self, visitor: &V) -> Error {
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
        Error::invalid_type(found, visitor)
    }
}

impl<'de> Deserializer<'de> for Tree {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
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

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let Value::Array(entries) = self.0 else { return Err(self.refused(&visitor)) };
        let mut entries = SeqDeserializer::new(entries.into_iter().map(Tree));
        let value = visitor.visit_seq(&mut entries)?;
        entries.end()?;
        Ok(value)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let Value::Table(entries) = self.0 else { return Err(self.refused(&visitor)) };
        visitor.visit_map(MapDeserializer::new(entries.into_iter().map(|(key, value)| (key, Tree(value)))))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_map(visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _length: usize, visitor: V) -> Result<V::Value, Error> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _name: &'static str, visitor: V) -> Result<V::Value, Error> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
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

impl<'de> IntoDeserializer<'de> for Tree {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
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
        ] {
            let (at, why) = read(text).unwrap_err();
            assert_eq!((at.as_str(), why.as_str()), (key, message), "{text}");
        }
    }
}
