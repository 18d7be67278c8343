//! Measured materials: which values are real, and which real material a value comes closest to.
//!
//! The table `data/measured.txt` is read once; its head says where each number comes from and what was left out.
//! Comparing takes no more than some microseconds, so that every row of an editor can ask in every frame.

mod compare;
mod material;
mod sentence;

use std::sync::OnceLock;

use burnish_material::{Kind, Property, Value};

pub use compare::{Near, Neighbours, marks, nearest, neighbours, zone};
pub use sentence::sentence;

/// One measurement of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Unique key, such as `n-bk7`.
    pub id: &'static str,
    /// Name shown to users. Two datasets of one material may share it.
    pub name: &'static str,
    /// Kind of material, such as `metal` or `glass`.
    pub group: &'static str,
    /// What was measured or follows from it. Lengths are in millimetres, colours may leave 0 to 1.
    pub values: Vec<(Property, Value)>,
    /// Lowest and highest value among several datasets of the same material.
    pub spreads: Vec<(Property, Value, Value)>,
    /// Where the numbers lie: a database, with the file or entry in it.
    pub dataset: &'static str,
    /// Paper, standard or page behind the numbers.
    pub reference: &'static str,
    /// Licence of the data.
    pub licence: &'static str,
}

impl Measured {
    /// What this measurement says of a property; lengths in millimetres.
    pub fn value(&self, property: Property) -> Option<Value> {
        self.values.iter().find(|(given, _)| *given == property).map(|(_, value)| *value)
    }

    /// Lowest and highest value among several datasets, channel by channel.
    pub fn spread(&self, property: Property) -> Option<(Value, Value)> {
        self.spreads.iter().find(|(given, ..)| *given == property).map(|(_, low, high)| (*low, *high))
    }

    /// Whether this follows from a physical law and not from a measurement.
    pub fn is_computed(&self) -> bool {
        self.dataset == "computed from physical law"
    }

    fn float(&self, property: Property) -> Option<f64> {
        if let Value::Float(value) = self.value(property)? { Some(value) } else { None }
    }

    fn color(&self, property: Property) -> Option<[f64; 3]> {
        if let Value::Color(value) = self.value(property)? { Some(value) } else { None }
    }
}

/// All measurements, in the order of the table: metals, clear and diffuse bodies, scattering and absorbing ones, lights.
pub fn measured() -> &'static [Measured] {
    static ROWS: OnceLock<Vec<Measured>> = OnceLock::new();
    ROWS.get_or_init(|| lines().filter_map(row).collect())
}

/// The measurement with this key.
pub fn find(id: &str) -> Option<&'static Measured> {
    measured().iter().find(|row| row.id == id)
}

/// The lines of the table that hold a measurement.
fn lines() -> impl Iterator<Item = &'static str> {
    include_str!("../data/measured.txt").lines().filter(|line| !line.starts_with('#'))
}

/// Reads one line; `None` if it does not follow the head of the table, which a test rules out for all of them.
fn row(line: &'static str) -> Option<Measured> {
    let mut fields = line.split('|');
    let mut next = || fields.next().map(str::trim);
    let (id, name, group) = (next()?, next()?, next()?);
    let values = entries(next()?).map(|entry| {
        let (property, text) = named(entry)?;
        Some((property, value(property, text)?))
    });
    let values = values.collect::<Option<_>>()?;
    let spreads = entries(next()?).map(|entry| {
        let (property, text) = named(entry)?;
        let (low, high) = text.split_once("..")?;
        Some((property, value(property, low)?, value(property, high)?))
    });
    let spreads = spreads.collect::<Option<_>>()?;
    let (dataset, reference, licence) = (next()?, next()?, next()?);
    next().is_none().then_some(Measured { id, name, group, values, spreads, dataset, reference, licence })
}

fn entries(field: &'static str) -> impl Iterator<Item = &'static str> {
    field.split(';').filter(|entry| !entry.is_empty())
}

fn named(entry: &'static str) -> Option<(Property, &'static str)> {
    let (name, text) = entry.split_once('=')?;
    Some((Property::from_name(name)?, text))
}

fn value(property: Property, text: &str) -> Option<Value> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
    let triple = || text.split(',').map(number).collect::<Option<Vec<_>>>()?.try_into().ok();
    match property.def().default.kind() {
        Kind::Float => number(text).map(Value::Float),
        Kind::Color => triple().map(Value::Color),
        Kind::Normal => triple().map(Value::Normal),
        Kind::Bool => text.parse().ok().map(Value::Bool),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_a_measurement() {
        for line in lines() {
            assert!(row(line).is_some(), "{line}");
        }
    }

    #[test]
    fn a_line_that_does_not_follow_the_head_is_refused() {
        let good = "a|A|metal|base_color=1,2,3;metallic=1|base_color=0,1,2..1,2,3|d|r|l";
        assert!(row(good).is_some());
        for bad in [
            "a|A|metal|base_color=1,2,3||d|r",
            "a|A|metal|base_color=1,2,3||d|r|l|more",
            "a|A|metal|base_color=1,2||d|r|l",
            "a|A|metal|no_such_property=1||d|r|l",
            "a|A|metal|metallic=inf||d|r|l",
            "a|A|metal|base_color=1,2,3|base_color=1,2,3|d|r|l",
        ] {
            assert!(row(bad).is_none(), "{bad}");
        }
    }
}
