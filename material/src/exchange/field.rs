//! Parameters of shading models: their tables, and what a file says about them.

use crate::properties::Property;
use crate::slot::TextureRef;
use crate::value::Value;

/// Every fact about one parameter of a shading model. Constant data.
#[derive(Clone, Copy, Debug)]
pub struct FieldDef {
    /// Its name in files, with what stands around it: `specular_roughness`, `KHR_materials_sheen.sheenColorFactor`.
    pub name: &'static str,
    /// Value where a file says nothing: the default of its format, not of ASM.
    pub default: Value,
    /// Properties that it is computed from.
    pub from: &'static [Property],
    /// Properties that follow it when somebody changes it.
    pub to: &'static [Property],
    /// Whether an image can stand in for it.
    pub takes_image: bool,
}

/// What a file says about one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Uniform value; the default where the file says nothing.
    pub value: Value,
    /// Image that stands in for it.
    pub texture: Option<TextureRef>,
    /// Whether the file says anything.
    pub is_authored: bool,
}

/// What a file says about all parameters of a shading model, in the order of its table.
#[derive(Clone, Debug, PartialEq)]
pub struct Fields(pub Vec<Field>);

impl Fields {
    /// All parameters at their defaults, none of them said.
    pub fn unsaid(table: &[FieldDef]) -> Self {
        Self(table.iter().map(|def| Field { value: def.default, texture: None, is_authored: false }).collect())
    }

    /// The uniform values.
    pub fn values(&self) -> Vec<Value> {
        self.0.iter().map(|field| field.value).collect()
    }

    /// The parameter of this name.
    pub fn get(&self, table: &[FieldDef], name: &str) -> Option<&Field> {
        table.iter().position(|def| def.name == name).and_then(|place| self.0.get(place))
    }

    /// The parameter of this name, to be set; it counts as said.
    pub fn say(&mut self, table: &[FieldDef], name: &str) -> Option<&mut Field> {
        let place = table.iter().position(|def| def.name == name)?;
        let field = self.0.get_mut(place)?;
        field.is_authored = true;
        Some(field)
    }
}

/// Declares the parameters of a shading model: a struct with one field each, its table, and the way between both.
///
/// `name: Kind(default), "name in files", from [properties], to [properties], image or uniform;`
#[macro_export]
macro_rules! shading_fields {
    (@type Color) => { [f64; 3] };
    (@type Normal) => { [f64; 3] };
    (@type Float) => { f64 };
    (@type Bool) => { bool };
    (@image image) => { true };
    (@image uniform) => { false };
    ($(#[doc = $top:literal])+ $model:ident { $( $(#[doc = $doc:literal])* $name:ident: $kind:ident($default:expr), $file:literal, from [$($from:ident),*], to [$($to:ident),*], $image:ident; )+ }) => {
        $(#[doc = $top])+
        #[allow(missing_docs)] // Names and meanings are those of the format.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $model { $( $(#[doc = $doc])* pub $name: $crate::shading_fields!(@type $kind) ),+ }

        impl $model {
            /// Its parameters.
            pub const FIELDS: &[$crate::exchange::field::FieldDef] = &[$( $crate::exchange::field::FieldDef {
                name: $file,
                default: $crate::Value::$kind($default),
                from: &[$($crate::Property::$from),*],
                to: &[$($crate::Property::$to),*],
                takes_image: $crate::shading_fields!(@image $image),
            } ),+];

            /// Its values in the order of the table.
            pub fn to_values(self) -> Vec<$crate::Value> {
                vec![$( $crate::Value::$kind(self.$name) ),+]
            }

            /// From values in the order of the table; what is missing or of another kind has its default.
            pub fn from_values(values: &[$crate::Value]) -> Self {
                let mut rest = values.iter();
                Self { $( $name: match rest.next() { Some($crate::Value::$kind(value)) => *value, _ => $default } ),+ }
            }
        }
    };
}
