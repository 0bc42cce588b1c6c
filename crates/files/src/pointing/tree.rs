//! XML elements of pointing files, with checks of their names, attributes and contents.

use super::unit;
use crate::exchange::{Piece, Wrong, elements};
use crate::spec::cut;
use roxmltree::Node;
use slewkit::Vector3;

/// An XML element of a pointing file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'t>(pub Node<'t, 't>);

impl<'t> Part<'t> {
    /// Returns the name of the element.
    pub fn name(self) -> Piece<'t> {
        elements::name(self.0)
    }

    /// Checks that the element has no attributes other than `attributes`, and no text between its
    /// child elements. Attributes with a namespace belong to the schema and are ignored.
    pub fn only(self, attributes: &[&str]) -> Result<Self, Wrong> {
        let other = self
            .0
            .attributes()
            .find(|attribute| attribute.namespace().is_none() && !attributes.contains(&attribute.name()));
        if let Some(other) = other {
            let at = Piece { at: other.range().start, text: other.name() };
            let (name, of) = (cut(at.text, 30), self.name().text);
            let reason = format!("the attribute {name} of <{of}> is not supported");
            return at.wrong(reason, "remove it: ignoring it could change the meaning of the timeline");
        }
        let text = self.0.children().find(|child| child.is_text() && !blank(child.text()));
        match text.filter(|_| self.0.first_element_child().is_some()) {
            Some(text) => {
                let at = Piece { at: text.range().start, text: text.text().unwrap_or_default() }.trimmed();
                at.wrong(format!("text between the elements of <{}>", self.name().text), "remove it")
            }
            None => Ok(self),
        }
    }

    /// Returns all child elements in order, or an error if the name of an element is not in
    /// `names`.
    pub fn all(self, names: &[&str]) -> Result<Vec<Self>, Wrong> {
        let parts: Vec<Self> = self.0.children().filter(Node::is_element).map(Part).collect();
        let other = parts.iter().find(|part| !names.contains(&part.name().text));
        if let Some(other) = other {
            let (inner, outer) = (cut(other.name().text, 40), cut(self.name().text, 40));
            let known = names.iter().map(|name| format!("<{name}>")).collect::<Vec<_>>().join(", ");
            let remedy = match names {
                [] => format!("<{outer}> must have no child elements here"),
                _ => format!("the supported elements of <{outer}> are {known}"),
            };
            return other.name().wrong(format!("<{inner}> in <{outer}> is not supported"), remedy);
        }
        Ok(parts)
    }

    /// Returns the child elements in the order of `names`; `None` for a missing element. Each name
    /// may occur at most once.
    pub fn parts<const N: usize>(self, names: [&str; N]) -> Result<[Option<Self>; N], Wrong> {
        let mut found = [None; N];
        for part in self.all(&names)? {
            let name = part.name();
            let Some(at) = names.iter().position(|known| *known == name.text) else { continue };
            if found[at].replace(part).is_some() {
                let reason = format!("<{}> occurs twice in <{}>", name.text, self.name().text);
                return name.wrong(reason, "give it once");
            }
        }
        Ok(found)
    }

    /// Returns the child element `part`, or an error that names it if it is `None`.
    pub fn needed(self, part: Option<Self>, name: &str) -> Result<Self, Wrong> {
        match part {
            Some(part) => Ok(part),
            None => self
                .name()
                .wrong(format!("<{}> has no <{name}>", cut(self.name().text, 40)), format!("add a <{name}>")),
        }
    }

    /// Returns the only child element, or an error if its name is not `name`.
    pub fn inner(self, name: &str) -> Result<Self, Wrong> {
        let [part] = self.parts([name])?;
        self.needed(part, name)
    }

    /// Returns an attribute of the element; `None` if it is absent.
    pub fn attribute(self, name: &str) -> Option<Piece<'t>> {
        elements::attribute(self.0, name)
    }

    /// Returns the attribute `name`, or an error if it is missing.
    pub fn said(self, name: &str) -> Result<Piece<'t>, Wrong> {
        match self.attribute(name) {
            Some(said) => Ok(said),
            None => {
                let of = cut(self.name().text, 40);
                self.name().wrong(format!("<{of}> has no attribute {name}"), format!("add {name}=\"…\""))
            }
        }
    }

    /// Checks that the attribute `name` exists and has the value `value`.
    pub fn is(self, name: &str, value: &str) -> Result<Self, Wrong> {
        let said = self.said(name)?;
        if said.text == value {
            return Ok(self);
        }
        let (of, found) = (cut(self.name().text, 40), cut(said.text, 40));
        said.wrong(
            format!("{name}=\"{found}\" of <{of}> is not supported"),
            format!("only {name}=\"{value}\" is supported here"),
        )
    }

    /// Returns the text of the element, which must not be empty.
    pub fn text(self) -> Result<Piece<'t>, Wrong> {
        self.all(&[])?;
        match elements::value(self.0)? {
            Some(text) => Ok(text),
            None => self.name().wrong(format!("<{}> is empty", cut(self.name().text, 40)), "give its text"),
        }
    }

    /// Checks that the element has neither text nor child elements.
    pub fn empty(self) -> Result<(), Wrong> {
        self.all(&[])?;
        match elements::value(self.0)? {
            Some(text) => text.wrong(format!("text in <{}>", cut(self.name().text, 40)), "leave it empty"),
            None => Ok(()),
        }
    }

    /// Returns the unit vector along a vector with three components, or an error if the vector is
    /// zero.
    pub fn direction(self, components: [f64; 3]) -> Result<Vector3, Wrong> {
        match unit(components.into()) {
            Some(direction) => Ok(direction),
            None => self.name().wrong("a vector of length zero has no direction", "give it a direction"),
        }
    }

    /// Returns the unit vector with the azimuth `about` around the third axis, and the elevation
    /// `towards` this axis \[rad\].
    pub fn spherical(self, about: f64, towards: f64) -> Result<Vector3, Wrong> {
        let ((sin, cos), (up, level)) = (about.sin_cos(), towards.sin_cos());
        self.direction([level * cos, level * sin, up])
    }
}

/// Returns an angle in radians, or an error if its absolute value exceeds `most` degrees.
pub(super) fn angle(value: Piece<'_>, unit: Piece<'_>, most: f64) -> Result<f64, Wrong> {
    let number = value.number()?.value;
    let radians = match unit.text {
        "deg" => number.to_radians(),
        "rad" => number,
        other => {
            let reason = format!("the unit {} of an angle is not supported", cut(other, 20));
            return unit.wrong(reason, "give angles in deg or rad");
        }
    };
    // The factor allows for rounding in the last digit of the file.
    if radians.abs() <= most.to_radians() * (1.0 + f64::EPSILON) {
        return Ok(radians);
    }
    let reason =
        format!("an angle of {} {} is outside -{most} to {most} deg", cut(value.text, 30), unit.text);
    value.wrong(reason, "check the unit and the order of the angles")
}

/// Returns whether a text is absent or blank.
fn blank(text: Option<&str>) -> bool {
    text.is_none_or(|text| text.trim().is_empty())
}
