//! One description of each map in the files: `described!` makes of it the Rust type, what reads it, and its [`Shape`].
//!
//! A key is named there and nowhere else, so that none can be read under another name than it is explained by.

use std::marker::PhantomData;

use nalgebra::Point3;

use crate::fault::Faults;
use crate::quantity::Quantity;
use crate::reader::{Fields, Item, Name, Written};
use crate::shape::{Form, Shape};

/// What reading needs beside the file: where faults go, and for some values more.
pub(crate) trait Context {
    /// The faults found so far.
    fn faults(&mut self) -> &mut Faults;
}

impl Context for Faults {
    fn faults(&mut self) -> &mut Faults {
        self
    }
}

/// A value that knows what it looks like.
pub(crate) trait Describes {
    /// For schema and reference.
    fn form(&self) -> Form;
}

/// The same, and how it is read.
pub(crate) trait Reads<'a, C>: Describes {
    /// What it is read as.
    type Out;

    /// The value; `None` when it is wrong, which is a fault.
    fn read(&self, item: Item<'a>, context: &mut C) -> Option<Self::Out>;
}

/// A type that is a map in the files.
pub(crate) trait Described {
    /// Its description.
    fn shape() -> &'static Shape;
}

/// A type that is read from a map once the keys of that are known to be right.
pub(crate) trait FromMap<'a, C>: Sized {
    /// All of it; `None` when something in it is wrong, which is a fault.
    fn from_map(fields: &Fields<'a>, context: &mut C) -> Option<Self>;
}

/// Describes a map of the files, as a struct of its keys or as an enum of which exactly one key stands there.
///
/// A field is `required`, `optional` or has a value (`or`) where its key is left out; if it is wrong, all is `None`. One
/// that is `wanted`, `maybe` there or has a value (`maybe_or`) is none by itself, a list or map (`wanted_all`,
/// `maybe_all`) is empty. `one` is a `choice` among keys
/// beside others.
macro_rules! described {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(<$life:lifetime>)? in $context:path: $what:literal, $doc:literal
        $(, others $others:expr, known [$($known:tt)*])? {
            $($(#[$field_meta:meta])* $field:ident: $ty:ty = $how:ident $arguments:tt),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug)]
        $vis struct $name $(<$life>)? {
            $($(#[$field_meta])* $vis $field: $ty,)*
        }

        impl $(<$life>)? $crate::describe::Described for $name $(<$life>)? {
            fn shape() -> &'static $crate::shape::Shape {
                static SHAPE: std::sync::LazyLock<$crate::shape::Shape> = std::sync::LazyLock::new(|| {
                    let mut shape = $crate::shape::Shape::new($what, $doc);
                    $($crate::describe::described!(@describe shape, $how $arguments);)*
                    $(
                        shape.others = Some($crate::shape::Others {
                            form: $crate::describe::Describes::form(&$others),
                            known: $crate::describe::described!(@fields $($known)*),
                        });
                    )?
                    shape
                });
                &SHAPE
            }
        }

        impl<'a, C: $context> $crate::describe::FromMap<'a, C> for $name $(<$life>)? {
            fn from_map(fields: &$crate::reader::Fields<'a>, context: &mut C) -> Option<Self> {
                $(let $field = $crate::describe::described!(@read fields, context, $how $arguments);)*
                Some(Self { $($field: $field?),* })
            }
        }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident in $context:path: $what:literal, $doc:literal { $($variants:tt)* }
    ) => {
        $crate::describe::described! {
            $(#[$meta])*
            $vis choice $name in $context { $($variants)* }
        }

        impl $crate::describe::Described for $name {
            fn shape() -> &'static $crate::shape::Shape {
                static SHAPE: std::sync::LazyLock<$crate::shape::Shape> = std::sync::LazyLock::new(|| {
                    let mut shape = $crate::shape::Shape::new($what, $doc);
                    shape.add_choice($name::choice());
                    shape
                });
                &SHAPE
            }
        }
    };
    (
        $(#[$meta:meta])*
        $vis:vis choice $name:ident in $context:path {
            $($variant:ident($ty:ty) = ($key:expr, $key_doc:expr, $form:expr)),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug)]
        $vis enum $name {
            $($variant($ty),)*
        }

        impl $name {
            fn choice() -> Vec<$crate::shape::Field> {
                $crate::describe::described!(@fields $(($key, $key_doc, $form)),*)
            }
        }

        impl<'a, C: $context> $crate::describe::FromMap<'a, C> for $name {
            fn from_map(fields: &$crate::reader::Fields<'a>, context: &mut C) -> Option<Self> {
                let item = fields.one()?;
                $(if item.key == $key {
                    return $crate::describe::Reads::read(&$form, item, context).map(Self::$variant);
                })*
                None
            }
        }
    };
    (@fields $(($key:expr, $doc:expr, $form:expr)),* $(,)?) => {
        vec![$($crate::describe::described!(@field $key, $doc, false, $form)),*]
    };
    (@field $key:expr, $doc:expr, $is_required:expr, $form:expr) => {
        $crate::shape::Field {
            key: $key,
            doc: $doc,
            is_required: $is_required,
            form: $crate::describe::Describes::form(&$form),
        }
    };
    (@describe $shape:ident, one($ty:ident)) => { $shape.add_choice($ty::choice()) };
    (@describe $shape:ident, required($key:expr, $doc:expr, $form:expr)) => {
        $shape.fields.push($crate::describe::described!(@field $key, $doc, true, $form))
    };
    (@describe $shape:ident, wanted $arguments:tt) => {
        $crate::describe::described!(@describe $shape, required $arguments)
    };
    (@describe $shape:ident, wanted_all $arguments:tt) => {
        $crate::describe::described!(@describe $shape, required $arguments)
    };
    (@describe $shape:ident, $how:ident($key:expr, $doc:expr, $form:expr $(, $default:expr)?)) => {
        $shape.fields.push($crate::describe::described!(@field $key, $doc, false, $form))
    };
    (@read $fields:ident, $context:ident, one($ty:ident)) => {
        $crate::describe::FromMap::from_map($fields, $context)
    };
    (@read $fields:ident, $context:ident, required($key:expr, $doc:expr, $form:expr)) => {
        $fields.read($key, &$form, $context)
    };
    (@read $fields:ident, $context:ident, optional($key:expr, $doc:expr, $form:expr)) => {
        $fields.read_optional($key, &$form, $context)
    };
    (@read $fields:ident, $context:ident, or($key:expr, $doc:expr, $form:expr, $default:expr)) => {
        $fields.read_optional($key, &$form, $context).map(|read| read.unwrap_or($default))
    };
    (@read $fields:ident, $context:ident, wanted($key:expr, $doc:expr, $form:expr)) => {
        Some($fields.read($key, &$form, $context))
    };
    (@read $fields:ident, $context:ident, maybe $arguments:tt) => {
        $crate::describe::described!(@read $fields, $context, wanted $arguments)
    };
    (@read $fields:ident, $context:ident, wanted_all($key:expr, $doc:expr, $form:expr)) => {
        Some($fields.read($key, &$form, $context).unwrap_or_default())
    };
    (@read $fields:ident, $context:ident, maybe_all $arguments:tt) => {
        $crate::describe::described!(@read $fields, $context, wanted_all $arguments)
    };
    (@read $fields:ident, $context:ident, maybe_or $arguments:tt) => {
        Some($crate::describe::described!(@read $fields, $context, or $arguments))
    };
}
pub(crate) use described;

/// A name; the text is what faults say was wanted: "a place".
#[derive(Debug, Clone, Copy)]
pub(crate) struct Word(pub(crate) &'static str);

/// A path: any text of one line; with what faults say was wanted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PathTo(pub(crate) &'static str);

/// `true` or `false`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flag;

/// A whole number up to that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Count(pub(crate) u32);

/// That many numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vector<const N: usize>(pub(crate) &'static Quantity);

/// Three numbers as a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point(pub(crate) &'static Quantity);

/// Two or three numbers; the third is none where there are two.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoOrThree(pub(crate) &'static Quantity);

/// A list that is not empty, with what faults call it; items that are wrong are left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct List<F>(pub(crate) &'static str, pub(crate) F);

/// A map from names that the writer chooses, with what faults call it; a name whose value is wrong is kept, so that it
/// is known.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Each<F>(pub(crate) &'static str, pub(crate) F);

/// A map whose keys are known.
#[derive(Debug)]
pub(crate) struct Map<T>(PhantomData<fn() -> T>);

/// The same value with its key and place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct At<F>(pub(crate) F);

/// A value that is read later, by what it is described by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Later(pub(crate) fn() -> Form);

impl<T> Map<T> {
    /// A map of that type.
    pub(crate) const fn new() -> Self {
        Self(PhantomData)
    }
}

/// Simple forms: what they look like, and how they are read.
macro_rules! forms {
    ($(
        [$($generics:tt)*] $form:ty => $out:ty: |$self:pat_param| $describes:expr,
        |$reader:pat_param, $item:ident, $faults:pat_param| $read:expr;
    )*) => {
        $(
            impl<$($generics)*> Describes for $form {
                fn form(&self) -> Form {
                    let $self = self;
                    $describes
                }
            }

            impl<'a, C: Context, $($generics)*> Reads<'a, C> for $form {
                type Out = $out;

                fn read(&self, $item: Item<'a>, context: &mut C) -> Option<$out> {
                    let ($reader, $faults) = (self, context.faults());
                    $read
                }
            }
        )*
    };
}

forms! {
    [] Word => Name: |_| Form::Word, |Word(what), item, faults| item.name(what, faults);
    [] PathTo => Name: |_| Form::Word, |PathTo(what), item, faults| item.path(what, faults);
    [] Flag => bool: |_| Form::Flag, |_, item, faults| item.flag(faults);
    [] Count => u32: |Count(most)| Form::Count(*most), |Count(most), item, faults| item.count(*most, faults);
    [] &'static Quantity => f64: |of| Form::Quantity(of), |of, item, faults| item.quantity(of, faults);
    [const N: usize] Vector<N> => [f64; N]: |Vector(of)| Form::Vector(N, N, of),
        |Vector(of), item, faults| <[f64; N]>::try_from(item.vector(N..=N, of, faults)?).ok();
    [] Point => Point3<f64>: |Point(of)| Form::Vector(3, 3, of),
        |Point(of), item, faults| item.vector(3..=3, of, faults).map(|at| Point3::from_slice(&at));
    [] TwoOrThree => ([f64; 2], Option<f64>): |TwoOrThree(of)| Form::Vector(2, 3, of),
        |TwoOrThree(of), item, faults| {
            let at = item.vector(2..=3, of, faults)?;
            Some(([at[0], at[1]], at.get(2).copied()))
        };
    [] Later => Item<'a>: |Later(of)| of(), |_, item, _| Some(item);
}

impl<F: Describes> Describes for List<F> {
    fn form(&self) -> Form {
        Form::List(Box::new(self.1.form()))
    }
}

impl<'a, C: Context, F: Reads<'a, C>> Reads<'a, C> for List<F> {
    type Out = Vec<F::Out>;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<Self::Out> {
        let items = item.list(self.0, context.faults())?;
        Some(items.into_iter().filter_map(|item| self.1.read(item, context)).collect())
    }
}

impl<F: Describes> Describes for Each<F> {
    fn form(&self) -> Form {
        Form::Each(Box::new(self.1.form()))
    }
}

impl<'a, C: Context, F: Reads<'a, C>> Reads<'a, C> for Each<F> {
    type Out = Vec<(Name, Option<F::Out>)>;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<Self::Out> {
        let entries = item.named(self.0, context.faults())?;
        Some(entries.into_iter().map(|(name, item)| (name, self.1.read(item, context))).collect())
    }
}

impl<T: Described> Describes for Map<T> {
    fn form(&self) -> Form {
        Form::Map(T::shape)
    }
}

impl<'a, C: Context, T: Described + FromMap<'a, C>> Reads<'a, C> for Map<T> {
    type Out = T;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<T> {
        let fields = item.fields(T::shape(), context.faults())?;
        T::from_map(&fields, context)
    }
}

impl<F: Describes> Describes for At<F> {
    fn form(&self) -> Form {
        self.0.form()
    }
}

impl<'a, C, F: Reads<'a, C>> Reads<'a, C> for At<F> {
    type Out = Written<F::Out>;

    fn read(&self, item: Item<'a>, context: &mut C) -> Option<Self::Out> {
        let value = self.0.read(item, context)?;
        Some(Written { value, key: item.key.to_owned(), span: item.span })
    }
}

impl<'a> Fields<'a> {
    /// The value of a key; `None` when it is left out or wrong.
    pub(crate) fn read<C, F: Reads<'a, C>>(&self, key: &str, form: &F, context: &mut C) -> Option<F::Out> {
        form.read(self.get(key)?, context)
    }

    /// The value of a key, if it is there; `None` when it is wrong.
    pub(crate) fn read_optional<C, F: Reads<'a, C>>(
        &self,
        key: &str,
        form: &F,
        context: &mut C,
    ) -> Option<Option<F::Out>> {
        self.get(key).map_or(Some(None), |item| form.read(item, context).map(Some))
    }
}
