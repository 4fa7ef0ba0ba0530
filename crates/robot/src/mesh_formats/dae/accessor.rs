//! The positions of a COLLADA mesh, read from an array by an accessor.

use clearance_geometry::math::Point;
use roxmltree::Node;

use super::{Collada, decimal, own_children, plain_attribute};

impl<'d> Collada<'d> {
    /// The positions that `<vertices>` refers to.
    pub(super) fn positions(&mut self, vertices: Node<'d, 'd>) -> Result<Vec<Point>, String> {
        let is_position = |n: &Node| plain_attribute(*n, "semantic") == Some("POSITION");
        let mut inputs = own_children(vertices, "input").filter(is_position);
        let input = match (inputs.next(), inputs.next()) {
            (Some(input), None) => input,
            (None, _) => return Err(self.at(vertices, "has no input POSITION")),
            (_, Some(second)) => return Err(self.at(second, "<vertices> may have only one input POSITION")),
        };
        let source = self.referenced(input, "source", &["source"])?;
        let technique = self.only_child(source, "technique_common")?;
        let Some(accessor) = technique.map(|t| self.only_child(t, "accessor")).transpose()?.flatten() else {
            return Err(self.at(source, "has no accessor"));
        };
        let array = self.referenced(accessor, "source", &["float_array", "int_array"])?;
        let numbers: Vec<f64> = (self.text(array)?.split_whitespace())
            .map(decimal)
            .collect::<Result<_, _>>()
            .map_err(|reason| self.at(array, reason))?;
        self.compare_count(array, numbers.len());
        let count = self.whole(accessor, "count", None)?;
        let stride = self.whole(accessor, "stride", Some(1))?;
        let offset = self.whole(accessor, "offset", Some(0))?;
        let [x, y, z] = self.coordinates(accessor)?;
        let least = 1 + x.max(y).max(z);
        if stride < least {
            let message =
                format!("positions have {least} numbers with its params, but the stride is {stride}");
            return Err(self.at(accessor, message));
        }
        let positions: Vec<Point> = (numbers.get(offset..).unwrap_or_default())
            .chunks(stride)
            .take(count)
            .filter_map(|p| Some(Point::new(*p.get(x)?, *p.get(y)?, *p.get(z)?)))
            .collect();
        if positions.len() != count {
            return Err(self
                .at(accessor, format!("the count is {count}, but {} positions are there", positions.len())));
        }
        Ok(positions)
    }

    /// Indices of x, y and z among the numbers of a position. Numbers whose `<param>` has no name are skipped, as the specification
    /// requires; names other than X, Y and Z do not determine the order.
    fn coordinates(&self, accessor: Node<'d, 'd>) -> Result<[usize; 3], String> {
        let params: Vec<Node> = own_children(accessor, "param").collect();
        if params.is_empty() {
            return Ok([0, 1, 2]);
        }
        let is_wide = |param: &&Node| {
            plain_attribute(**param, "type").is_some_and(|t| t.ends_with(|c: char| c.is_ascii_digit()))
        };
        if let Some(wide) = params.iter().find(is_wide) {
            return Err(self.at(*wide, "its type has more than one number, which is not read"));
        }
        let name = |param: &Node| {
            plain_attribute(*param, "name").map(str::trim).filter(|n| !n.is_empty()).map(str::to_uppercase)
        };
        let named: Vec<(usize, String)> =
            params.iter().enumerate().filter_map(|(place, param)| Some((place, name(param)?))).collect();
        let places = ["X", "Y", "Z"].map(|axis| {
            let mut of_axis = named.iter().filter(|(_, name)| name == axis).map(|(place, _)| *place);
            (of_axis.next(), of_axis.next())
        });
        match (places, &named[..]) {
            ([(Some(x), None), (Some(y), None), (Some(z), None)], _) => Ok([x, y, z]),
            ([(None, _), (None, _), (None, _)], [(a, _), (b, _), (c, _), ..]) => Ok([*a, *b, *c]),
            _ => {
                let message = format!(
                    "positions need params named X, Y and Z once, but {} of its params have names",
                    named.len()
                );
                Err(self.at(accessor, message))
            }
        }
    }

    /// A whole number from an attribute.
    pub(super) fn whole(&self, node: Node, attribute: &str, missing: Option<usize>) -> Result<usize, String> {
        match (plain_attribute(node, attribute).map(str::trim), missing) {
            (Some(text), _) => text
                .parse()
                .map_err(|_| self.at(node, format!("the attribute {attribute} is no whole number"))),
            (None, Some(value)) => Ok(value),
            (None, None) => Err(self.at(node, format!("has no attribute {attribute}"))),
        }
    }
}
