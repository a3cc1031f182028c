//! Writes structures without the fields that say nothing.
//!
//! A record holds thousands of claims, and most of their fields are empty. A field is left out when it is what
//! `Default` gives: no number but 0, no text, no list, nothing. `Some` of anything is written, as are names of
//! variants, so that reading with `#[serde(default)]` gives back exactly what was written. The elements of lists and
//! tuples are never left out.

use serde::ser::{self, Impossible, Serialize, Serializer};
use std::fmt;

/// A value that is written without its empty fields.
pub(crate) struct Compact<'a, T: ?Sized>(pub &'a T);

impl<T: Serialize + ?Sized> Serialize for Compact<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(Skipping(serializer))
    }
}

/// Structures that are written whole: there is one of each, and without them a text is no record.
const WHOLE: [&str; 3] = ["Provenance", "RunRecord", "Totals"];

/// A serializer that leaves empty fields out and hands everything else on.
struct Skipping<S>(S);

/// Hands methods on whose argument is a plain value.
macro_rules! hand_on {
    ($($method:ident: $type:ty),* $(,)?) => {
        $(fn $method(self, value: $type) -> Result<Self::Ok, Self::Error> { self.0.$method(value) })*
    };
}

impl<S: Serializer> Serializer for Skipping<S> {
    type Ok = S::Ok;
    type Error = S::Error;
    type SerializeSeq = Skipping<S::SerializeSeq>;
    type SerializeTuple = Skipping<S::SerializeTuple>;
    type SerializeTupleStruct = Skipping<S::SerializeTupleStruct>;
    type SerializeTupleVariant = Skipping<S::SerializeTupleVariant>;
    type SerializeMap = Skipping<S::SerializeMap>;
    type SerializeStruct = CompactFields<S::SerializeStruct>;
    type SerializeStructVariant = Skipping<S::SerializeStructVariant>;

    hand_on!(
        serialize_bool: bool,
        serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64,
        serialize_f32: f32, serialize_f64: f64,
        serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
    );

    fn serialize_none(self) -> Result<S::Ok, S::Error> {
        self.0.serialize_none()
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<S::Ok, S::Error> {
        self.0.serialize_some(&Compact(value))
    }
    fn serialize_unit(self) -> Result<S::Ok, S::Error> {
        self.0.serialize_unit()
    }
    fn serialize_unit_struct(self, name: &'static str) -> Result<S::Ok, S::Error> {
        self.0.serialize_unit_struct(name)
    }
    fn serialize_unit_variant(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
    ) -> Result<S::Ok, S::Error> {
        self.0.serialize_unit_variant(name, index, variant)
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        value: &T,
    ) -> Result<S::Ok, S::Error> {
        self.0.serialize_newtype_struct(name, &Compact(value))
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<S::Ok, S::Error> {
        self.0.serialize_newtype_variant(name, index, variant, &Compact(value))
    }
    fn serialize_seq(self, len: Option<usize>) -> Result<Self::SerializeSeq, S::Error> {
        self.0.serialize_seq(len).map(Skipping)
    }
    fn serialize_tuple(self, len: usize) -> Result<Self::SerializeTuple, S::Error> {
        self.0.serialize_tuple(len).map(Skipping)
    }
    fn serialize_tuple_struct(
        self,
        name: &'static str,
        len: usize,
    ) -> Result<Self::SerializeTupleStruct, S::Error> {
        self.0.serialize_tuple_struct(name, len).map(Skipping)
    }
    fn serialize_tuple_variant(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<Self::SerializeTupleVariant, S::Error> {
        self.0.serialize_tuple_variant(name, index, variant, len).map(Skipping)
    }
    fn serialize_map(self, len: Option<usize>) -> Result<Self::SerializeMap, S::Error> {
        self.0.serialize_map(len).map(Skipping)
    }
    fn serialize_struct(self, name: &'static str, len: usize) -> Result<Self::SerializeStruct, S::Error> {
        Ok(CompactFields { inner: self.0.serialize_struct(name, len)?, whole: WHOLE.contains(&name) })
    }
    fn serialize_struct_variant(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
        len: usize,
    ) -> Result<Self::SerializeStructVariant, S::Error> {
        self.0.serialize_struct_variant(name, index, variant, len).map(Skipping)
    }
}

/// The fields of a structure.
struct CompactFields<S> {
    inner: S,
    /// Empty ones are written, too.
    whole: bool,
}

impl<S: ser::SerializeStruct> ser::SerializeStruct for CompactFields<S> {
    type Ok = S::Ok;
    type Error = S::Error;

    fn serialize_field<T: Serialize + ?Sized>(
        &mut self,
        key: &'static str,
        value: &T,
    ) -> Result<(), S::Error> {
        if !self.whole && value.serialize(Empty).is_ok() {
            return self.inner.skip_field(key);
        }
        self.inner.serialize_field(key, &Compact(value))
    }
    fn end(self) -> Result<S::Ok, S::Error> {
        self.inner.end()
    }
}

/// The parts of lists, maps and variants, which are all written.
macro_rules! every_part {
    ($($part:ident { $($method:ident($($name:ident: $type:ty),*)),* })*) => {
        $(impl<S: ser::$part> ser::$part for Skipping<S> {
            type Ok = S::Ok;
            type Error = S::Error;
            $(fn $method<T: Serialize + ?Sized>(&mut self, $($name: $type,)* value: &T) -> Result<(), S::Error> {
                self.0.$method($($name,)* &Compact(value))
            })*
            fn end(self) -> Result<S::Ok, S::Error> {
                self.0.end()
            }
        })*
    };
}

every_part! {
    SerializeSeq { serialize_element() }
    SerializeTuple { serialize_element() }
    SerializeTupleStruct { serialize_field() }
    SerializeTupleVariant { serialize_field() }
    SerializeMap { serialize_key(), serialize_value() }
    SerializeStructVariant { serialize_field(key: &'static str) }
}

/// A serializer that writes nothing: it succeeds with a value that `Default` gives, and fails with any other.
struct Empty;

/// The value says something.
#[derive(Debug)]
struct Says;

impl fmt::Display for Says {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the value is not empty")
    }
}
impl std::error::Error for Says {}
impl ser::Error for Says {
    fn custom<T: fmt::Display>(_: T) -> Self {
        Says
    }
}

/// Succeeds where `holds`.
fn if_empty(holds: bool) -> Result<(), Says> {
    if holds { Ok(()) } else { Err(Says) }
}

macro_rules! empty_if_zero {
    ($($method:ident: $type:ty),* $(,)?) => {
        $(fn $method(self, value: $type) -> Result<(), Says> { if_empty(value == <$type>::default()) })*
    };
}

impl Serializer for Empty {
    type Ok = ();
    type Error = Says;
    type SerializeSeq = EmptyList;
    type SerializeTuple = Impossible<(), Says>;
    type SerializeTupleStruct = Impossible<(), Says>;
    type SerializeTupleVariant = Impossible<(), Says>;
    type SerializeMap = Impossible<(), Says>;
    type SerializeStruct = EmptyList;
    type SerializeStructVariant = Impossible<(), Says>;

    empty_if_zero!(
        serialize_bool: bool,
        serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64,
        serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
    );

    fn serialize_f32(self, value: f32) -> Result<(), Says> {
        if_empty(value.to_bits() == 0)
    }
    fn serialize_f64(self, value: f64) -> Result<(), Says> {
        // The bits: 0 has a sign.
        if_empty(value.to_bits() == 0)
    }
    fn serialize_none(self) -> Result<(), Says> {
        Ok(())
    }
    fn serialize_some<T: Serialize + ?Sized>(self, _: &T) -> Result<(), Says> {
        Err(Says)
    }
    fn serialize_unit(self) -> Result<(), Says> {
        Err(Says)
    }
    fn serialize_unit_struct(self, _: &'static str) -> Result<(), Says> {
        Err(Says)
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Result<(), Says> {
        Err(Says)
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Result<(), Says> {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: &T,
    ) -> Result<(), Says> {
        Err(Says)
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<EmptyList, Says> {
        Ok(EmptyList)
    }
    fn serialize_tuple(self, _: usize) -> Result<Self::SerializeTuple, Says> {
        Err(Says)
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Self::SerializeTupleStruct, Says> {
        Err(Says)
    }
    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeTupleVariant, Says> {
        Err(Says)
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Self::SerializeMap, Says> {
        Err(Says)
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<EmptyList, Says> {
        Ok(EmptyList)
    }
    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        _: &'static str,
        _: usize,
    ) -> Result<Self::SerializeStructVariant, Says> {
        Err(Says)
    }
}

/// A list without elements, or a structure whose fields are all empty.
struct EmptyList;

impl ser::SerializeSeq for EmptyList {
    type Ok = ();
    type Error = Says;
    fn serialize_element<T: Serialize + ?Sized>(&mut self, _: &T) -> Result<(), Says> {
        Err(Says)
    }
    fn end(self) -> Result<(), Says> {
        Ok(())
    }
}

impl ser::SerializeStruct for EmptyList {
    type Ok = ();
    type Error = Says;
    fn serialize_field<T: Serialize + ?Sized>(&mut self, _: &'static str, value: &T) -> Result<(), Says> {
        value.serialize(Empty)
    }
    fn end(self) -> Result<(), Says> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
    #[serde(default)]
    struct Inner {
        at: Option<i64>,
        on: bool,
    }

    #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
    #[serde(default)]
    struct Outer {
        name: String,
        inner: Inner,
        list: Vec<Inner>,
        some: Option<String>,
        pair: Option<[i64; 2]>,
        part: f64,
    }

    fn written(value: &Outer) -> String {
        let text = serde_json::to_string(&Compact(value)).unwrap();
        assert_eq!(&serde_json::from_str::<Outer>(&text).unwrap(), value, "{text}");
        text
    }

    #[test]
    fn only_what_says_nothing_is_left_out() {
        assert_eq!(written(&Outer::default()), "{}");
        // Something of nothing is not nothing, and an element is never left out.
        let inner = Inner { at: Some(0), on: false };
        let full = Outer {
            name: "a".into(),
            inner: inner.clone(),
            list: vec![Inner::default(), inner],
            some: Some(String::new()),
            pair: Some([0, 0]),
            part: -0.0,
        };
        assert_eq!(
            written(&full),
            r#"{"name":"a","inner":{"at":0},"list":[{},{"at":0}],"some":"","pair":[0,0],"part":-0.0}"#
        );
    }
}
