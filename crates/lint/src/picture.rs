//! Renders pictures of a link: collision and visual geometry in one orthographic view, with depth buffers.

// pixels and colours are small whole numbers
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]

use clearance_geometry::Triangle;
use clearance_geometry::math::{Extremes, Point, Vector};

use crate::png;

/// Width of a picture (pixels).
pub(crate) const WIDTH: usize = 480;
/// Height of a picture (pixels).
pub(crate) const HEIGHT: usize = 360;
/// Number of tests of pixels after which the rest of a surface is not drawn.
const MOST_TESTS: usize = 300_000_000;
/// Free space around the geometry (pixels).
const MARGIN: f64 = 24.0;

const VISUAL: [f64; 3] = [112.0, 136.0, 170.0];
const COLLISION: [f64; 3] = [240.0, 168.0, 64.0];
const UNPROTECTED: [f64; 3] = [212.0, 62.0, 62.0];
const BACKGROUND: [f64; 3] = [250.0, 250.0, 248.0];

/// Depth difference, relative to the size of the scene, above which one surface is in front of the other.
const IN_FRONT: f64 = 2e-3;

/// An orthographic view of a box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    right: Vector,
    up: Vector,
    towards: Vector,
    centre: Point,
    /// Pixels per metre.
    scale: f64,
}

impl View {
    /// View of a box from the octant in which `point` lies.
    pub fn facing([low, high]: [Point; 2], point: &Point) -> Self {
        let centre = low + (high - low) * 0.5;
        let side = |i: usize| if point[i] < centre[i] { -1.0 } else { 1.0 };
        let towards = Vector::new(side(0), 0.7 * side(1), 0.55 * side(2)).normalize();
        let right = Vector::z().cross(&towards).normalize();
        let up = towards.cross(&right);
        let mut view = Self { right, up, towards, centre, scale: 1.0 };
        let corner = |i: usize, axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let (mut across, mut along) = (0.0_f64, 0.0_f64);
        for i in 0..8 {
            let from_centre = Point::new(corner(i, 0), corner(i, 1), corner(i, 2)) - centre;
            across = across.greater(right.dot(&from_centre).abs());
            along = along.greater(up.dot(&from_centre).abs());
        }
        let fit = |pixels: usize, extent: f64| (0.5 * pixels as f64 - MARGIN) / extent.greater(1e-9);
        view.scale = fit(WIDTH, across).lesser(fit(HEIGHT, along));
        view
    }

    /// Column, row and depth (m, larger is nearer) of a point.
    pub fn project(&self, point: &Point) -> [f64; 3] {
        let from_centre = point - self.centre;
        let column = 0.5 * WIDTH as f64 + self.scale * self.right.dot(&from_centre);
        let row = 0.5 * HEIGHT as f64 - self.scale * self.up.dot(&from_centre);
        [column, row, self.towards.dot(&from_centre)]
    }

    /// A length (m) as a round number that fits beside the picture, and its pixels.
    pub fn scale_bar(&self) -> (f64, f64) {
        let longest = 0.25 * WIDTH as f64 / self.scale;
        let power = 10.0_f64.powf(longest.log10().floor());
        let length = [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|l| *l <= longest);
        let length = length.unwrap_or(power);
        (length, length * self.scale)
    }
}

/// The nearest surface of each pixel: depth (m), and brightness.
struct DepthBuffer(Vec<(f64, f64)>);

impl DepthBuffer {
    /// Also returns whether all triangles are drawn.
    fn of(triangles: &[Triangle], view: &View) -> (Self, bool) {
        let mut buffer = Self(vec![(f64::NEG_INFINITY, 0.0); WIDTH * HEIGHT]);
        let light = (view.towards + view.up * 0.6 - view.right * 0.4).normalize();
        let mut tests = 0;
        for triangle in triangles {
            if tests > MOST_TESTS {
                return (buffer, false);
            }
            let brightness = 0.35 + 0.65 * triangle.normal().dot(&light).abs();
            tests += buffer.draw(&triangle.corners().map(|p| view.project(&p)), brightness);
        }
        (buffer, true)
    }

    /// Draws a triangle; returns the number of tests of pixels.
    fn draw(&mut self, &[a, b, c]: &[[f64; 3]; 3], brightness: f64) -> usize {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area.abs() < 1e-9 {
            return 1;
        }
        let span = |i: usize, most: usize| {
            let low = a[i].lesser(b[i]).lesser(c[i]).floor().clamp(0.0, most as f64);
            let high = a[i].greater(b[i]).greater(c[i]).ceil().clamp(0.0, most as f64);
            low as usize..high as usize
        };
        let (rows, columns) = (span(1, HEIGHT), span(0, WIDTH));
        let tests = 1 + rows.len() * columns.len();
        for row in rows {
            for column in columns.clone() {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let weight = |p: [f64; 3], q: [f64; 3]| {
                    ((q[0] - p[0]) * (y - p[1]) - (x - p[0]) * (q[1] - p[1])) / area
                };
                let [of_c, of_a, of_b] = [weight(a, b), weight(b, c), weight(c, a)];
                if of_a < 0.0 || of_b < 0.0 || of_c < 0.0 {
                    continue;
                }
                let depth = of_a * a[2] + of_b * b[2] + of_c * c[2];
                let pixel = &mut self.0[row * WIDTH + column];
                if depth > pixel.0 {
                    *pixel = (depth, brightness);
                }
            }
        }
        tests
    }
}

/// PNG of a view, in base 64, and whether all triangles are drawn. Collision geometry is translucent; visual geometry in front of it is red.
pub(crate) fn draw(view: &View, collision: &[Triangle], visual: &[Triangle]) -> (String, bool) {
    let [(collision, has_collision), (visual, has_visual)] =
        [collision, visual].map(|triangles| DepthBuffer::of(triangles, view));
    let in_front = IN_FRONT * WIDTH as f64 / view.scale;
    let mut rgb = Vec::with_capacity(3 * WIDTH * HEIGHT);
    for (collision, visual) in collision.0.iter().zip(&visual.0) {
        let is_drawn = |pixel: &(f64, f64)| pixel.0 > f64::NEG_INFINITY;
        let colour = match (is_drawn(collision), is_drawn(visual)) {
            (false, false) => BACKGROUND,
            (true, false) => mixed(shaded(COLLISION, collision.1), BACKGROUND, 0.75),
            (false, true) => shaded(UNPROTECTED, visual.1),
            (true, true) if visual.0 > collision.0 + in_front => shaded(UNPROTECTED, visual.1),
            (true, true) if collision.0 > visual.0 + in_front => {
                mixed(shaded(COLLISION, collision.1), shaded(VISUAL, visual.1), 0.5)
            }
            (true, true) => shaded(VISUAL, visual.1),
        };
        rgb.extend(colour.map(|c| c.clamp(0.0, 255.0) as u8));
    }
    (png::base64(&png::encode(WIDTH as u32, HEIGHT as u32, &rgb)), has_collision && has_visual)
}

fn shaded(colour: [f64; 3], brightness: f64) -> [f64; 3] {
    colour.map(|c| c * brightness)
}

fn mixed(first: [f64; 3], second: [f64; 3], share: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| share * first[i] + (1.0 - share) * second[i])
}
