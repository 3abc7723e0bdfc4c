//! Strict JSON that keeps every number: floats in the fewest digits that read back to the same bits,
//! what is not finite as the strings `"inf"`, `"-inf"` and `"nan"`.

use std::fmt::Display;

use serde::ser::{self, Serialize};

/// `value` as JSON; see the module.
///
/// # Errors
/// A map with keys that are no strings, or an error of the value itself.
pub fn to_json<T: Serialize + ?Sized>(value: &T) -> Result<Vec<u8>, JsonError> {
    let mut json = Json { out: Vec::with_capacity(1024) };
    value.serialize(&mut json)?;
    Ok(json.out)
}

/// Why a value has no JSON.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct JsonError(String);

impl ser::Error for JsonError {
    fn custom<T: Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

struct Json {
    out: Vec<u8>,
}

impl Json {
    fn text(&mut self, text: &str) -> Result<(), JsonError> {
        serde_json::to_writer(&mut self.out, text).map_err(ser::Error::custom)
    }

    /// Everything that `serde_json` already writes exactly.
    fn exact<T: Serialize>(&mut self, value: T) -> Result<(), JsonError> {
        serde_json::to_writer(&mut self.out, &value).map_err(ser::Error::custom)
    }

    fn open(&mut self, bracket: &str) -> Nested<'_> {
        self.out.extend_from_slice(bracket.as_bytes());
        Nested { json: self, first: true, close: "" }
    }
}

/// Inside an array or object.
struct Nested<'a> {
    json: &'a mut Json,
    first: bool,
    close: &'static str,
}

impl<'a> Nested<'a> {
    fn closing(self, close: &'static str) -> Self {
        Self { close, ..self }
    }

    fn comma(&mut self) {
        if !std::mem::replace(&mut self.first, false) {
            self.json.out.push(b',');
        }
    }

    fn element<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), JsonError> {
        self.comma();
        value.serialize(&mut *self.json)
    }

    fn field<T: Serialize + ?Sized>(&mut self, key: &str, value: &T) -> Result<(), JsonError> {
        self.comma();
        self.json.text(key)?;
        self.json.out.push(b':');
        value.serialize(&mut *self.json)
    }

    fn done(self) -> Result<(), JsonError> {
        self.json.out.extend_from_slice(self.close.as_bytes());
        Ok(())
    }
}

macro_rules! exact {
    ($($method:ident: $kind:ty),*) => {
        $(fn $method(self, value: $kind) -> Result<(), JsonError> {
            self.exact(value)
        })*
    };
}

impl<'a> ser::Serializer for &'a mut Json {
    type Ok = ();
    type Error = JsonError;
    type SerializeSeq = Nested<'a>;
    type SerializeTuple = Nested<'a>;
    type SerializeTupleStruct = Nested<'a>;
    type SerializeTupleVariant = Nested<'a>;
    type SerializeMap = Nested<'a>;
    type SerializeStruct = Nested<'a>;
    type SerializeStructVariant = Nested<'a>;

    exact!(
        serialize_bool: bool, serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_char: char,
        serialize_str: &str
    );

    fn serialize_f32(self, value: f32) -> Result<(), JsonError> {
        self.serialize_f64(f64::from(value))
    }

    fn serialize_f64(self, value: f64) -> Result<(), JsonError> {
        if value.is_finite() {
            self.exact(value)
        } else if value.is_nan() {
            self.text("nan")
        } else {
            self.text(if value > 0.0 { "inf" } else { "-inf" })
        }
    }

    fn serialize_bytes(self, value: &[u8]) -> Result<(), JsonError> {
        self.exact(value)
    }

    fn serialize_none(self) -> Result<(), JsonError> {
        self.serialize_unit()
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<(), JsonError> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Result<(), JsonError> {
        self.out.extend_from_slice(b"null");
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Result<(), JsonError> {
        self.serialize_unit()
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Result<(), JsonError> {
        self.text(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        value: &T,
    ) -> Result<(), JsonError> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<(), JsonError> {
        let mut object = self.open("{").closing("}");
        object.field(variant, value)?;
        object.done()
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Nested<'a>, JsonError> {
        Ok(self.open("[").closing("]"))
    }

    fn serialize_tuple(self, _: usize) -> Result<Nested<'a>, JsonError> {
        Ok(self.open("[").closing("]"))
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Nested<'a>, JsonError> {
        Ok(self.open("[").closing("]"))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Nested<'a>, JsonError> {
        self.out.push(b'{');
        self.text(variant)?;
        Ok(self.open(":[").closing("]}"))
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Nested<'a>, JsonError> {
        Ok(self.open("{").closing("}"))
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Nested<'a>, JsonError> {
        Ok(self.open("{").closing("}"))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Nested<'a>, JsonError> {
        self.out.push(b'{');
        self.text(variant)?;
        Ok(self.open(":{").closing("}}"))
    }
}

macro_rules! elements {
    ($($part:ident: $method:ident),*) => {
        $(impl ser::$part for Nested<'_> {
            type Ok = ();
            type Error = JsonError;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), JsonError> {
                self.element(value)
            }

            fn end(self) -> Result<(), JsonError> {
                self.done()
            }
        })*
    };
}

macro_rules! fields {
    ($($part:ident),*) => {
        $(impl ser::$part for Nested<'_> {
            type Ok = ();
            type Error = JsonError;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), JsonError> {
                self.field(key, value)
            }

            fn end(self) -> Result<(), JsonError> {
                self.done()
            }
        })*
    };
}

elements!(
    SerializeSeq: serialize_element, SerializeTuple: serialize_element, SerializeTupleStruct: serialize_field,
    SerializeTupleVariant: serialize_field
);
fields!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for Nested<'_> {
    type Ok = ();
    type Error = JsonError;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), JsonError> {
        self.comma();
        let from = self.json.out.len();
        key.serialize(&mut *self.json)?;
        if self.json.out.get(from) == Some(&b'"') {
            Ok(())
        } else {
            Err(ser::Error::custom("a key of a JSON object must be a string"))
        }
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), JsonError> {
        self.json.out.push(b':');
        value.serialize(&mut *self.json)
    }

    fn end(self) -> Result<(), JsonError> {
        self.done()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use serde::Serialize;

    use super::*;

    #[derive(Serialize)]
    #[serde(tag = "kind", rename_all = "snake_case")]
    enum Tagged {
        Plain,
        Full { a_m: f64, more: Vec<Option<f64>> },
    }

    #[derive(Serialize)]
    enum Outside {
        One(f64),
        Two { x: u8 },
        Pair(u8, bool),
    }

    #[derive(Serialize)]
    struct Everything {
        tagged: [Tagged; 2],
        outside: (Outside, Outside, Outside),
        by_name: BTreeMap<String, f64>,
        empty: Vec<u8>,
        text: &'static str,
    }

    #[test]
    fn what_is_finite_is_written_as_serde_json_does() {
        let value = Everything {
            tagged: [Tagged::Plain, Tagged::Full { a_m: 0.1 + 0.2, more: vec![None, Some(-1e-300)] }],
            outside: (Outside::One(1.0), Outside::Two { x: 3 }, Outside::Pair(4, true)),
            by_name: BTreeMap::from([("µ".to_owned(), 1.5), ("a\"b".to_owned(), 2.0)]),
            empty: Vec::new(),
            text: "line\nbreak",
        };
        assert_eq!(to_json(&value).unwrap(), serde_json::to_vec(&value).unwrap());
    }

    #[test]
    fn what_is_not_finite_is_a_string_and_nothing_is_null_but_none() {
        let written = to_json(&[Some(f64::INFINITY), Some(f64::NEG_INFINITY), Some(f64::NAN), None]).unwrap();
        assert_eq!(String::from_utf8(written).unwrap(), r#"["inf","-inf","nan",null]"#);
    }
}
