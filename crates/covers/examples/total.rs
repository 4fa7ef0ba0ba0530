use clearance_covers::*;
use clearance_robot::RobotModel;
use std::{
    path::{Path, PathBuf},
    time::Instant,
};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let packages: Vec<PathBuf> = a[2].split(':').map(PathBuf::from).collect();
    let robot = RobotModel::load(Path::new(&a[1]), None, &packages).unwrap();
    let v: f64 = a[4].parse().unwrap();
    let size = match a[3].as_str() {
        "total" => CoverSize::Total(v as usize),
        "count" => CoverSize::PerLink(v as usize),
        _ => CoverSize::Excess(v),
    };
    let t = Instant::now();
    let c = if a.get(5).is_some() {
        inner_sphere_cover(&robot, &size, &|_| ())
    } else {
        sphere_cover(&robot, &size, &|_| ())
    }
    .unwrap();
    for l in &c.links {
        println!("{:32} {:3} {:.5} {:.5}", robot.link(l.link).name, l.spheres.len(), l.error[0], l.error[1]);
    }
    println!("{} spheres, {:.5} m, {:.1} s", c.count(), c.largest_error(), t.elapsed().as_secs_f64());
}
