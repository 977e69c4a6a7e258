//! Records as JSON in which every id is a name: a serializer around that of JSON which is told what a number is an id
//! of. What is not an id stays as the journal has it.

use serde::Serialize;
use serde::ser::{
    Error, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple, SerializeTupleStruct,
    SerializeTupleVariant, Serializer,
};

use ambidex_model::{
    ChannelId, ControllerId, FactId, Names, NodeId, NodeRange, ObjectId, PlaceId, Record, ResourceId, TypeId,
};

/// A record as one line of JSON, without its end, with names where the journal has ids; its times are the journal's.
///
/// # Errors
/// Never with a record that came out of a journal.
pub fn json(record: &Record, names: &Names) -> serde_json::Result<String> {
    serde_json::to_string(&With { value: record, names })
}

/// A value that is written with names.
struct With<'a, T: ?Sized> {
    value: &'a T,
    names: &'a Names,
}

impl<T: Serialize + ?Sized> Serialize for With<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.serialize(Named { inner: serializer, names: self.names })
    }
}

/// Writes ids as names, and everything else as the serializer within does.
struct Named<'a, S> {
    inner: S,
    names: &'a Names,
}

/// A list or object under way.
struct Open<'a, C> {
    inner: C,
    names: &'a Names,
}

/// A struct under way; a run of nodes becomes the list of their names.
enum OpenStruct<'a, S: Serializer> {
    Fields(Open<'a, S::SerializeStruct>),
    NodeRange { inner: S, names: &'a Names, ends: Vec<u32> },
}

/// The name behind an id of a type; none for types that are no ids.
fn name<'a>(ty: &str, id: u32, names: &'a Names) -> Option<&'a str> {
    Some(match ty {
        "NodeId" => names.node(NodeId(id)),
        "ResourceId" => names.resource(ResourceId(id)),
        "TypeId" => names.ty(TypeId(id)),
        "ChannelId" => names.channel(ChannelId(id)),
        "ObjectId" => names.object(ObjectId(id)),
        "PlaceId" => names.place(PlaceId(id)),
        "FactId" => names.fact(FactId(id)),
        "ControllerId" => names.controller(ControllerId(id)),
        _ => return None,
    })
}

/// The number that a value is.
fn number<E: Error>(value: &(impl Serialize + ?Sized)) -> Result<Option<u32>, E> {
    let value = serde_json::to_value(value).map_err(E::custom)?;
    Ok(value.as_u64().and_then(|number| u32::try_from(number).ok()))
}

/// Methods that hand on what can be no id.
macro_rules! hand_on {
    ($($method:ident($($arg:ident: $ty:ty),*);)+) => {$(
        fn $method(self, $($arg: $ty),*) -> Result<S::Ok, S::Error> {
            self.inner.$method($($arg),*)
        }
    )+};
}

/// Methods that open a list or object.
macro_rules! open {
    ($($method:ident($($arg:ident: $ty:ty),*) -> $open:ident;)+) => {$(
        fn $method(self, $($arg: $ty),*) -> Result<Open<'a, S::$open>, S::Error> {
            Ok(Open { inner: self.inner.$method($($arg),*)?, names: self.names })
        }
    )+};
}

impl<'a, S: Serializer> Serializer for Named<'a, S> {
    type Ok = S::Ok;
    type Error = S::Error;
    type SerializeSeq = Open<'a, S::SerializeSeq>;
    type SerializeTuple = Open<'a, S::SerializeTuple>;
    type SerializeTupleStruct = Open<'a, S::SerializeTupleStruct>;
    type SerializeTupleVariant = Open<'a, S::SerializeTupleVariant>;
    type SerializeMap = Open<'a, S::SerializeMap>;
    type SerializeStruct = OpenStruct<'a, S>;
    type SerializeStructVariant = Open<'a, S::SerializeStructVariant>;

    hand_on! {
        serialize_bool(value: bool);
        serialize_i8(value: i8);
        serialize_i16(value: i16);
        serialize_i32(value: i32);
        serialize_i64(value: i64);
        serialize_u8(value: u8);
        serialize_u16(value: u16);
        serialize_u32(value: u32);
        serialize_u64(value: u64);
        serialize_f32(value: f32);
        serialize_f64(value: f64);
        serialize_char(value: char);
        serialize_str(value: &str);
        serialize_bytes(value: &[u8]);
        serialize_none();
        serialize_unit();
        serialize_unit_struct(name: &'static str);
        serialize_unit_variant(name: &'static str, index: u32, variant: &'static str);
    }

    open! {
        serialize_seq(len: Option<usize>) -> SerializeSeq;
        serialize_tuple(len: usize) -> SerializeTuple;
        serialize_tuple_struct(name: &'static str, len: usize) -> SerializeTupleStruct;
        serialize_tuple_variant(name: &'static str, index: u32, variant: &'static str, len: usize)
            -> SerializeTupleVariant;
        serialize_map(len: Option<usize>) -> SerializeMap;
        serialize_struct_variant(name: &'static str, index: u32, variant: &'static str, len: usize)
            -> SerializeStructVariant;
    }

    fn serialize_struct(self, name: &'static str, len: usize) -> Result<OpenStruct<'a, S>, S::Error> {
        if name == "NodeRange" {
            return Ok(OpenStruct::NodeRange { inner: self.inner, names: self.names, ends: Vec::with_capacity(len) });
        }
        let inner = self.inner.serialize_struct(name, len)?;
        Ok(OpenStruct::Fields(Open { inner, names: self.names }))
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Result<S::Ok, S::Error> {
        self.inner.serialize_some(&With { value, names: self.names })
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, ty: &'static str, value: &T) -> Result<S::Ok, S::Error> {
        if ty.ends_with("Id")
            && let Some(id) = number(value)?
            && let Some(name) = name(ty, id, self.names)
        {
            return self.inner.serialize_str(name);
        }
        self.inner.serialize_newtype_struct(ty, &With { value, names: self.names })
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        index: u32,
        variant: &'static str,
        value: &T,
    ) -> Result<S::Ok, S::Error> {
        self.inner.serialize_newtype_variant(name, index, variant, &With { value, names: self.names })
    }
}

/// Lists: every item with names.
macro_rules! items {
    ($($list:ident $method:ident;)+) => {$(
        impl<C: $list> $list for Open<'_, C> {
            type Ok = C::Ok;
            type Error = C::Error;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), C::Error> {
                self.inner.$method(&With { value, names: self.names })
            }
            fn end(self) -> Result<C::Ok, C::Error> {
                self.inner.end()
            }
        }
    )+};
}

items! {
    SerializeSeq serialize_element;
    SerializeTuple serialize_element;
    SerializeTupleStruct serialize_field;
    SerializeTupleVariant serialize_field;
}

impl<C: SerializeMap> SerializeMap for Open<'_, C> {
    type Ok = C::Ok;
    type Error = C::Error;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), C::Error> {
        self.inner.serialize_key(key)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), C::Error> {
        self.inner.serialize_value(&With { value, names: self.names })
    }

    fn end(self) -> Result<C::Ok, C::Error> {
        self.inner.end()
    }
}

impl<C: SerializeStructVariant> SerializeStructVariant for Open<'_, C> {
    type Ok = C::Ok;
    type Error = C::Error;

    fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), C::Error> {
        self.inner.serialize_field(key, &With { value, names: self.names })
    }

    fn end(self) -> Result<C::Ok, C::Error> {
        self.inner.end()
    }
}

impl<S: Serializer> SerializeStruct for OpenStruct<'_, S> {
    type Ok = S::Ok;
    type Error = S::Error;

    fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), S::Error> {
        match self {
            Self::Fields(open) => open.inner.serialize_field(key, &With { value, names: open.names }),
            Self::NodeRange { ends, .. } => {
                ends.extend(number::<S::Error>(value)?);
                Ok(())
            }
        }
    }

    fn end(self) -> Result<S::Ok, S::Error> {
        match self {
            Self::Fields(open) => open.inner.end(),
            Self::NodeRange { inner, names, ends } => match ends.as_slice() {
                &[from, to] => {
                    let span = NodeRange { from: NodeId(from), to: NodeId(to) };
                    let nodes: Vec<&str> = span.nodes(names.nodes.len()).map(|node| names.node(node)).collect();
                    inner.collect_seq(nodes)
                }
                _ => Err(S::Error::custom("a span has two ends")),
            },
        }
    }
}
