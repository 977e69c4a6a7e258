//! One description of each map in the files: `described!` makes of it the Rust type, what reads it, and its [`Shape`].
//!
//! A key is named there and nowhere else, so that none can be read under another name than it is explained by.

use std::marker::PhantomData;

use nalgebra::Point3;

use crate::fault::Faults;
use crate::quantity::Quantity;
use crate::reader::{Fields, Item, Name, Written};
use crate::scope::Reading;
use crate::shape::{Form, Shape};

/// What a value looks like, and how it is read.
pub(crate) trait Reads<'a> {
    /// What it is read as.
    type Out;

    /// For schema and reference.
    fn form(&self) -> Form;

    /// The value; `None` when it is wrong, which is a fault.
    fn read(&self, item: Item<'a>, reading: &mut Reading<'_>) -> Option<Self::Out>;

    /// The same outside of a behavior.
    fn take(&self, item: Item<'a>, faults: &mut Faults) -> Option<Self::Out> {
        self.read(item, &mut Reading::new(faults))
    }
}

/// A type that is a map in the files.
pub(crate) trait Described<'a>: Sized {
    /// What may stand in the map.
    fn shape() -> &'static Shape;

    /// All of it, once its keys are known to be right; `None` when a value is wrong, which is a fault.
    fn from_map(fields: &Fields<'a>, reading: &mut Reading<'_>) -> Option<Self>;

    /// All of it; `None` when something in it is wrong, which is a fault.
    fn read(item: Item<'a>, reading: &mut Reading<'_>) -> Option<Self> {
        Self::from_map(&item.fields(Self::shape(), reading.faults)?, reading)
    }

    /// The same outside of a behavior.
    fn take(item: Item<'a>, faults: &mut Faults) -> Option<Self> {
        Self::read(item, &mut Reading::new(faults))
    }
}

/// Describes a map of the files, as a struct of its keys or as an enum of which exactly one key stands there.
///
/// A field is `required`, `optional` or has a value (`or`) where its key is left out; if it is wrong, all is `None`. One
/// that is `wanted`, `maybe` there or has a value (`maybe_or`) is none by itself, a list or map (`wanted_all`,
/// `maybe_all`) is empty. `one` is an enum whose keys stand
/// beside others, `all` is a struct whose keys do.
macro_rules! described {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident $(<$life:lifetime>)?: $what:literal, $doc:literal
        $(, others $others:expr, known [$($known:tt)*])? {
            $($(#[$field_meta:meta])* $field:ident: $ty:ty = $how:ident $arguments:tt),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug)]
        $vis struct $name $(<$life>)? {
            $($(#[$field_meta])* $vis $field: $ty,)*
        }

        impl<'a> $crate::describe::Described<'a> for $name $(<$life>)? {
            $crate::describe::described!(@shape $what, $doc, |shape| {
                $($crate::describe::described!(@describe shape, $how $arguments);)*
                $(
                    shape.others = Some($crate::shape::Others {
                        form: $crate::describe::Reads::form(&$others),
                        known: $crate::describe::described!(@fields $($known)*),
                    });
                )?
            });

            fn from_map(
                fields: &$crate::reader::Fields<'a>,
                reading: &mut $crate::scope::Reading<'_>,
            ) -> Option<Self> {
                $(let $field = $crate::describe::described!(@read fields, reading, $how $arguments);)*
                Some(Self { $($field: $field?),* })
            }
        }
    };
    (
        $(#[$meta:meta])*
        $vis:vis enum $name:ident: $what:literal, $doc:literal {
            $($variant:ident($ty:ty) = ($key:expr, $key_doc:expr, $form:expr)),* $(,)?
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug)]
        $vis enum $name {
            $($variant($ty),)*
        }

        impl<'a> $crate::describe::Described<'a> for $name {
            $crate::describe::described!(@shape $what, $doc, |shape| {
                shape.add_choice($crate::describe::described!(@fields $(($key, $key_doc, $form)),*));
            });

            fn from_map(
                fields: &$crate::reader::Fields<'a>,
                reading: &mut $crate::scope::Reading<'_>,
            ) -> Option<Self> {
                let item = fields.one()?;
                $(if item.key == $key {
                    return $crate::describe::Reads::read(&$form, item, reading).map(Self::$variant);
                })*
                None
            }
        }
    };
    (@shape $what:literal, $doc:literal, |$shape:ident| $fill:block) => {
        fn shape() -> &'static $crate::shape::Shape {
            static SHAPE: std::sync::LazyLock<$crate::shape::Shape> = std::sync::LazyLock::new(|| {
                let mut $shape = $crate::shape::Shape::new($what, $doc);
                $fill
                $shape
            });
            &SHAPE
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
            form: $crate::describe::Reads::form(&$form),
        }
    };
    (@describe $shape:ident, one($ty:ident)) => {
        $shape.add_choice(<$ty as $crate::describe::Described<'_>>::shape().fields.clone())
    };
    (@describe $shape:ident, all($ty:ident)) => {
        $shape.fields.extend(<$ty as $crate::describe::Described<'_>>::shape().fields.clone())
    };
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
        $crate::describe::Described::from_map($fields, $context)
    };
    (@read $fields:ident, $context:ident, all($ty:ident)) => {
        $crate::describe::Described::from_map($fields, $context)
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

/// A whole number no farther from 0 than that.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Whole(pub(crate) i32);

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

/// A value of its own kind: what it looks like, and how it is read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Custom<T>(pub(crate) fn() -> Form, pub(crate) fn(Item<'_>, &mut Reading<'_>) -> Option<T>);

impl<T> Map<T> {
    /// A map of that type.
    pub(crate) const fn new() -> Self {
        Self(PhantomData)
    }
}

/// What each form looks like, and how it is read.
macro_rules! forms {
    ($(
        [$($generics:tt)*] $form:ty => $out:ty: |$self:pat_param| $describes:expr,
        |$reader:pat_param, $item:ident, $reading:pat_param| $read:expr;
    )*) => {
        $(impl<'a, $($generics)*> Reads<'a> for $form {
            type Out = $out;

            fn form(&self) -> Form {
                let $self = self;
                $describes
            }

            fn read(&self, $item: Item<'a>, $reading: &mut Reading<'_>) -> Option<$out> {
                let $reader = self;
                $read
            }
        })*
    };
}

forms! {
    [] Word => Name: |_| Form::Word, |Word(what), item, reading| item.name(what, reading.faults);
    [] PathTo => Name: |_| Form::Word, |PathTo(what), item, reading| item.path(what, reading.faults);
    [] Flag => bool: |_| Form::Flag, |_, item, reading| item.flag(reading.faults);
    [] Count => u32: |Count(most)| Form::Count(*most), |Count(most), item, reading| item.count(*most, reading.faults);
    [] Whole => i32: |Whole(most)| Form::Whole(*most), |Whole(most), item, reading| item.whole(*most, reading.faults);
    [] &'static Quantity => f64: |of| Form::Quantity(of), |of, item, reading| item.quantity(of, reading.faults);
    [const N: usize] Vector<N> => [f64; N]: |Vector(of)| Form::Vector(N, N, of),
        |Vector(of), item, reading| <[f64; N]>::try_from(item.vector(N..=N, of, reading.faults)?).ok();
    [] Point => Point3<f64>: |Point(of)| Form::Vector(3, 3, of),
        |Point(of), item, reading| item.vector(3..=3, of, reading.faults).map(|at| Point3::from_slice(&at));
    [] TwoOrThree => ([f64; 2], Option<f64>): |TwoOrThree(of)| Form::Vector(2, 3, of),
        |TwoOrThree(of), item, reading| {
            let at = item.vector(2..=3, of, reading.faults)?;
            Some(([at[0], at[1]], at.get(2).copied()))
        };
    [F: Reads<'a>] List<F> => Vec<F::Out>: |List(_, of)| Form::List(Box::new(of.form())),
        |List(what, of), item, reading| {
            let items = item.list(what, reading.faults)?;
            Some(items.into_iter().filter_map(|item| of.read(item, reading)).collect())
        };
    [F: Reads<'a>] Each<F> => Vec<(Name, Option<F::Out>)>: |Each(_, of)| Form::Each(Box::new(of.form())),
        |Each(what, of), item, reading| {
            let entries = item.named(what, reading.faults)?;
            Some(entries.into_iter().map(|(name, item)| (name, of.read(item, reading))).collect())
        };
    [T: Described<'a>] Map<T> => T: |_| Form::Map(T::shape), |_, item, reading| T::read(item, reading);
    [F: Reads<'a>] At<F> => Written<F::Out>: |At(of)| of.form(), |At(of), item, reading| {
        let value = of.read(item, reading)?;
        Some(Written { value, key: item.key.to_owned(), span: item.span })
    };
    [] Later => Item<'a>: |Later(of)| of(), |_, item, _| Some(item);
    [T] Custom<T> => T: |Custom(form, _)| form(), |Custom(_, read), item, reading| read(item, reading);
}

impl<'a> Fields<'a> {
    /// The value of a key; `None` when it is left out or wrong.
    pub(crate) fn read<F: Reads<'a>>(&self, key: &str, form: &F, reading: &mut Reading<'_>) -> Option<F::Out> {
        form.read(self.get(key)?, reading)
    }

    /// The value of a key, if it is there; `None` when it is wrong.
    pub(crate) fn read_optional<F: Reads<'a>>(
        &self,
        key: &str,
        form: &F,
        reading: &mut Reading<'_>,
    ) -> Option<Option<F::Out>> {
        self.get(key).map_or(Some(None), |item| form.read(item, reading).map(Some))
    }
}
