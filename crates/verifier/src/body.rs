//! Body of the verifier: its elements in a binary tree of boxes, and its planes.

use clearance_geometry::math::{Extremes, Point, Pose, Vector};
use clearance_geometry::{Plane, Primitive, Shape};

use super::element::Element;
use super::interior::Interior;

type Translation = nalgebra::Translation3<f64>;

/// A link or an obstacle in its own frame.
#[derive(Debug)]
pub(super) struct Body {
    elements: Vec<Element>,
    /// None without elements.
    nodes: Vec<Node>,
    planes: Vec<Plane>,
    /// `None` where meshes are surfaces.
    pub interior: Option<Interior>,
}

/// A box along the body's axes, and a ball with the same centre; both contain all elements below the node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub centre: Point,
    pub half: Vector,
    pub radius: f64,
    pub content: Content,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Content {
    Element(usize),
    Children([usize; 2]),
}

/// A unit direction, with the absolute values of its components.
#[derive(Clone, Copy)]
struct Direction<'d> {
    n: &'d Vector,
    n_abs: &'d Vector,
}

impl Body {
    /// A body of shapes at their poses; there must be at least one shape.
    pub fn new(shapes: &[(Pose, &Shape)], solid_meshes: bool) -> Self {
        let (mut elements, mut planes) = (Vec::new(), Vec::new());
        for (pose, shape) in shapes {
            match shape {
                Shape::Plane(plane) => planes.push(plane.transformed(pose)),
                Shape::Points(cloud) => elements.extend(cloud.points().iter().map(|p| {
                    let ball = Primitive::Sphere { radius: cloud.radius() };
                    Element::primitive(&ball, &(pose * Translation::from(p.map(f64::from))))
                })),
                Shape::Voxels(voxels) => elements.extend(voxels.cubes().iter().map(|cube| {
                    let solid = Primitive::Box { half_extents: [f64::from(cube.half_edge); 3] };
                    Element::primitive(&solid, &(pose * Translation::from(cube.centre.map(f64::from))))
                })),
                Shape::Primitive(primitive) => elements.push(Element::primitive(primitive, pose)),
                Shape::Mesh(mesh) => {
                    let triangles = (0..mesh.triangles().len()).map(|i| mesh.triangle(i));
                    elements.extend(triangles.map(|t| Element::triangle(&t, pose)));
                }
            }
        }
        let bounds: Vec<[Point; 2]> = elements.iter().map(Element::bounds).collect();
        let mut order: Vec<usize> = (0..elements.len()).collect();
        let mut nodes = Vec::with_capacity(2 * elements.len());
        if !elements.is_empty() {
            Builder { elements: &elements, bounds: &bounds, nodes: &mut nodes }.build(&mut order);
        }
        Self { elements, nodes, planes, interior: solid_meshes.then(|| Interior::new(shapes)) }
    }

    /// The node around all elements.
    pub fn root(&self) -> Option<&Node> {
        self.nodes.first()
    }

    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    pub fn node(&self, index: usize) -> &Node {
        &self.nodes[index]
    }

    pub fn element(&self, index: usize) -> &Element {
        &self.elements[index]
    }

    #[cfg(test)]
    pub fn elements(&self) -> &[Element] {
        &self.elements
    }

    /// Corners of the box around all elements; without elements, the point of a plane nearest to the origin.
    pub fn box_corners(&self) -> [Point; 8] {
        let Some(Node { centre, half, .. }) = self.root() else {
            return [self.planes.first().map_or_else(Point::origin, Plane::foot); 8];
        };
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
            centre + half.component_mul(&Vector::new(sign(1), sign(2), sign(4)))
        })
    }

    /// The largest n·x of all points x below a node, and the element where it is.
    pub fn support(&self, node: usize, n: &Vector) -> (f64, &Element) {
        let mut best = (f64::NEG_INFINITY, 0);
        self.climb(node, &Direction { n, n_abs: &n.abs() }, &mut best);
        (best.0, &self.elements[best.1])
    }

    fn climb(&self, node: usize, direction: &Direction, best: &mut (f64, usize)) {
        let Direction { n, n_abs } = *direction;
        let top = |node: usize| n.dot(&self.nodes[node].centre.coords) + n_abs.dot(&self.nodes[node].half);
        match self.nodes[node].content {
            Content::Element(e) => {
                let support = self.elements[e].support(n);
                if support > best.0 {
                    *best = (support, e);
                }
            }
            Content::Children([l, r]) => {
                let mut tops = [(l, top(l)), (r, top(r))];
                if tops[1].1 > tops[0].1 {
                    tops.swap(0, 1);
                }
                for (child, top) in tops {
                    // a NaN bound excludes nothing
                    let beyond = top <= best.0;
                    if !beyond {
                        self.climb(child, direction, best);
                    }
                }
            }
        }
    }

    /// True if all elements are on one side of a plane, at least `target` (m) from it.
    pub fn is_clear_of(&self, plane: &Plane, target: f64) -> bool {
        let n = plane.normal.into_inner();
        let is_unit = (n.norm_squared() - 1.0).abs() <= 1e-14;
        is_unit
            && (self.nodes.is_empty()
                || self.node_is_clear_of(0, &Direction { n: &n, n_abs: &n.abs() }, plane, target))
    }

    fn node_is_clear_of(&self, index: usize, direction: &Direction, plane: &Plane, target: f64) -> bool {
        let Direction { n, n_abs } = *direction;
        let node = &self.nodes[index];
        let (height, reach) = (plane.height(&node.centre), n_abs.dot(&node.half));
        if height - reach >= target || -height - reach >= target {
            return true;
        }
        match node.content {
            Content::Element(e) => {
                let (high, low) = (self.elements[e].support(n), -self.elements[e].support(&-n));
                low - plane.offset >= target || plane.offset - high >= target
            }
            Content::Children(pair) => {
                pair.iter().all(|child| self.node_is_clear_of(*child, direction, plane, target))
            }
        }
    }

    /// Upper bound on a convex, non-negative function over the body, where the function changes by at most `slope` per metre. Only nodes
    /// that may contain its maximum are searched.
    pub fn greatest(&self, slope: f64, function: impl Fn(&Point) -> f64) -> f64 {
        let mut greatest = 0.0;
        let most = |node: &Node| function(&node.centre) + slope * node.radius;
        let mut open = if self.nodes.is_empty() { vec![] } else { vec![(0, f64::INFINITY)] };
        while let Some((index, most_here)) = open.pop() {
            if most_here <= greatest {
                continue;
            }
            match self.nodes[index].content {
                Content::Element(e) => {
                    greatest = self.elements[e].greatest(slope, &function).greater(greatest);
                }
                Content::Children(children) => {
                    let mut pair = children.map(|c| (c, most(&self.nodes[c])));
                    if pair[0].1 > pair[1].1 {
                        pair.swap(0, 1);
                    }
                    open.extend(pair);
                }
            }
        }
        greatest
    }
}

struct Builder<'b> {
    elements: &'b [Element],
    bounds: &'b [[Point; 2]],
    nodes: &'b mut Vec<Node>,
}

impl Builder<'_> {
    /// Adds the tree over some elements and returns its root. Halves are as equal as possible, so the depth is the number of bits of the
    /// count.
    fn build(&mut self, order: &mut [usize]) -> usize {
        let index = self.nodes.len();
        self.nodes.push(self.around(order));
        if let [element] = order {
            self.nodes[index].content = Content::Element(*element);
            return index;
        }
        let axis = self.widest(order);
        let middle = order.len() / 2;
        let bounds = self.bounds;
        let place = |e: usize| bounds[e][0][axis] + bounds[e][1][axis];
        order.select_nth_unstable_by(middle, |x, y| place(*x).total_cmp(&place(*y)));
        let (first, second) = order.split_at_mut(middle);
        let children = [self.build(first), self.build(second)];
        self.nodes[index].content = Content::Children(children);
        index
    }

    fn around(&self, order: &[usize]) -> Node {
        let [low, high] = (order.iter().map(|e| self.bounds[*e]))
            .reduce(|x, y| [x[0].inf(&y[0]), x[1].sup(&y[1])])
            .expect("a body has elements");
        let centre = nalgebra::center(&low, &high);
        let far = |e: &usize| self.elements[*e].greatest(1.0, |p| nalgebra::distance(p, &centre));
        // the ball around the box may be smaller than a ball around corners of round elements
        let half = (high - low) * 0.5;
        let radius = order.iter().map(far).fold(0.0, f64::greater).lesser(half.norm());
        Node { centre, half, radius, content: Content::Children([0; 2]) }
    }

    /// The axis along which the centres of elements spread most.
    fn widest(&self, order: &[usize]) -> usize {
        let middles = order.iter().map(|e| nalgebra::center(&self.bounds[*e][0], &self.bounds[*e][1]));
        let range = middles
            .fold([Point::from([f64::INFINITY; 3]), Point::from([-f64::INFINITY; 3])], |r, m| {
                [r[0].inf(&m), r[1].sup(&m)]
            });
        (range[1] - range[0]).imax()
    }
}
