use clearance_covers::{link_solid::LinkSolid, outer_cover::*};
use clearance_robot::RobotModel;
use std::{path::{Path, PathBuf}, time::Instant};
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let packages: Vec<PathBuf> = a[2].split(':').map(PathBuf::from).collect();
    let robot = RobotModel::load(Path::new(&a[1]), None, &packages).unwrap();
    // counts from the spherized URDF
    let counts = RobotModel::load(Path::new(&a[3]), None, &packages).unwrap();
    let (mut worst, mut theirs) = (0.0_f64, 0.0_f64);
    for link in robot.links() {
        let Some(solid) = LinkSolid::of_link(link).unwrap() else { continue };
        let n = counts.link_by_name(&link.name).map_or(0, |l| counts.link(l).collisions.len());
        if n == 0 || a.get(4).is_some_and(|f| !link.name.contains(f.as_str())) { continue }
        let t = Instant::now();
        let cover = OuterCover::new(&solid);
        let balls: Vec<_> = counts.link(counts.link_by_name(&link.name).unwrap()).collisions.iter().map(|c| { let clearance_geometry::Shape::Primitive(clearance_geometry::Primitive::Sphere { radius }) = c.shape else { panic!() }; clearance_covers::ball::Ball { centre: c.pose_ls.translation.vector.into(), radius } }).collect();
        let u = clearance_covers::measure::uncovered_area(&solid, &balls);
        let e = clearance_covers::measure::excesses(&solid, &balls, &clearance_covers::excess::Accuracy { relative: 0.01, absolute: 1e-6, most_cells: 100000 });
        let e = e.iter().map(|e| e.upper).fold(0.0, f64::max);
        let t1 = t.elapsed().as_secs_f64();
        let c = cover.of_count(n);
        (worst, theirs) = (worst.max(largest_excess(&c)), theirs.max(e));
        print!("theirs {e:.5} uncovered {:.1} - {:.1} % ", 100.0 * u.lower / u.total, 100.0 * u.upper / u.total);
        println!("{:32} n {:2} -> {:2}  excess {:.5} [{:.5}]  grid {:.2} s, all {:.2} s, {} triangles, extent {:.3}, inside {}", link.name, n, c.len(), largest_excess(&c), c.iter().map(|b| b.1.lower).fold(0.0, f64::max), t1, t.elapsed().as_secs_f64(), solid.triangles().count(), solid.extent(), solid.has_inside());
    }
    println!("worst {worst:.5} theirs {theirs:.5}");
}
