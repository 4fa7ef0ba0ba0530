//! Tests of forged certificates, altered at random and signed again: accepted ones are free and as expected.
//!
//! `CLEARANCE_SOUNDNESS=long` makes 10⁵ of them.

use clearance::motion::{Certificate, MovingObstacle, Proof, SegmentText};
use clearance::verifier::{ExpectedMotion, Verifier};
use rayon::prelude::*;

use super::bases::{Base, bases, followers};
use super::brute_force::Room;
use super::{Scene, resign};
use crate::random::Random;
use crate::soundness::share;
use crate::tally::Tally;

fn pick<'t, T>(random: &mut Random, all: &'t mut [T]) -> Option<&'t mut T> {
    let count = u32::try_from(all.len()).unwrap();
    (count > 0).then(|| &mut all[random.below(count) as usize])
}

/// Another number in place of one.
fn alter(random: &mut Random, x: f64) -> f64 {
    let small = 10f64.powf(random.within(-17.0, 0.5)) * [-1.0, 1.0][random.below(2) as usize];
    match random.below(14) {
        0..=4 => x + small,
        5 | 6 => x * (1.0 + small),
        7 => -x,
        8 => 0.0,
        9 => x.next_up(),
        10 => x.next_down(),
        11 => [1e300, -1e300, 1e9, 1e-300, 1.0, 2.0][random.below(6) as usize],
        12 => [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0][random.below(4) as usize],
        _ => x * 0.5,
    }
}

fn alter_one(random: &mut Random, numbers: &mut [f64]) {
    if let Some(x) = pick(random, numbers) {
        *x = alter(random, *x);
    }
}

fn alter_motion(random: &mut Random, text: &mut SegmentText, size: usize) {
    match random.below(10) {
        0 | 1 => alter_one(random, text.from.as_deref_mut().unwrap_or_default()),
        2 | 3 => alter_one(random, text.to.as_deref_mut().unwrap_or_default()),
        4 | 5 => match pick(random, text.polynomials.as_deref_mut().unwrap_or_default()) {
            Some(p) if random.below(2) == 0 => {
                // the same ends
                let (i, j) = (1 + random.below(5) as usize, 1 + random.below(5) as usize);
                let by = random.within(-2.0, 2.0);
                (p[i], p[j]) = (p[i] + by, p[j] - by);
            }
            Some(p) => alter_one(random, p),
            None => {}
        },
        6 => {
            if text.tube.len() != size {
                text.tube = vec![0.0; size];
            }
            alter_one(random, &mut text.tube);
        }
        7 => match pick(random, &mut text.obstacles) {
            Some(o) => {
                let which = random.below(3) as usize;
                let [centre, linear, angular] = [&mut o.centre, &mut o.linear, &mut o.angular];
                alter_one(random, [centre, linear, angular][which]);
            }
            None => text.obstacles.push(mover(random)),
        },
        8 => {
            if let Some(o) = pick(random, &mut text.obstacles) {
                let (xyz, q) = o.start.get_or_insert(([0.0; 3], [0.0, 0.0, 0.0, 1.0]));
                if random.below(2) == 0 { alter_one(random, xyz) } else { alter_one(random, q) }
            }
        }
        _ => bend(random, text),
    }
}

/// The same ends by another way, or a polynomial that is straight.
fn bend(random: &mut Random, text: &mut SegmentText) {
    let (Some(from), Some(to)) = (text.from.take(), text.to.take()) else { return };
    let by = [0.0, 0.1, 3.0][random.below(3) as usize];
    let bent = from.iter().zip(&to).map(|(a, b)| [*a, b - a + by, -by, 0.0, 0.0, 0.0]).collect();
    text.polynomials = Some(bent);
}

fn mover(random: &mut Random) -> MovingObstacle {
    let name = ["ball", "box", "sheet", "wall", "held", "tool"][random.below(6) as usize].to_owned();
    let linear = random.vector(1.0).into();
    let far = Some(([0.0, 100.0, 0.0], [0.0, 0.0, 0.0, 1.0]));
    let start = if random.below(2) == 0 { far } else { None };
    MovingObstacle { name, centre: [0.0; 3], linear, angular: [0.0; 3], start }
}

fn alter_proofs(random: &mut Random, proofs: &mut Vec<Proof>, pairs: usize) {
    let count = u32::try_from(proofs.len()).unwrap();
    if count == 0 {
        return;
    }
    let i = random.below(count) as usize;
    match random.below(8) {
        0 => {
            proofs.remove(i);
        }
        1 => proofs.insert(i, proofs[random.below(count) as usize]),
        2 => proofs.swap(i, random.below(count) as usize),
        3 => proofs[i].0 = random.below(u32::try_from(pairs).unwrap() + 2) as usize,
        // one interval in place of several
        4 => {
            let pair = proofs[i].0;
            let most = proofs.iter().filter(|p| p.0 == pair).map(|p| p.3).fold(0.0, f64::max);
            proofs.retain(|p| p.0 != pair);
            proofs.push(Proof(pair, 0.0, 1.0, most, most * random.within(0.0, 1.0)));
        }
        _ => {
            let p = &mut proofs[i];
            let numbers = [&mut p.1, &mut p.2, &mut p.3, &mut p.4];
            let x = numbers.into_iter().nth(random.below(4) as usize).unwrap();
            *x = alter(random, *x);
        }
    }
}

fn alter_segments(random: &mut Random, certificate: &mut Certificate) {
    let count = u32::try_from(certificate.segments.len()).unwrap();
    if count == 0 {
        return;
    }
    let [i, j] = [(); 2].map(|()| random.below(count) as usize);
    match random.below(6) {
        0 => {
            certificate.segments.remove(i);
        }
        1 => certificate.segments.insert(j, certificate.segments[i].clone()),
        2 => certificate.segments.swap(i, j),
        3 => certificate.segments.reverse(),
        4 => certificate.segments[i].motion = certificate.segments[j].motion.clone(),
        // both sides of a joint
        _ => {
            let by = 10f64.powf(random.within(-17.0, -8.0));
            let away = [0.0, by, -by][random.below(3) as usize];
            let shift = |list: Option<&mut Vec<f64>>, by: f64| {
                if let Some(list) = list {
                    for x in list {
                        *x += by;
                    }
                }
            };
            shift(certificate.segments[i].motion.to.as_mut(), by);
            if let Some(next) = certificate.segments.get_mut(i + 1) {
                shift(next.motion.from.as_mut(), away);
            }
        }
    }
}

fn alter_rest(random: &mut Random, certificate: &mut Certificate) {
    let swap = |random: &mut Random, list: &mut Vec<String>| {
        if let [first, .., last] = list.as_mut_slice() {
            if random.below(2) == 0 { std::mem::swap(first, last) } else { last.push('x') }
        }
    };
    match random.below(8) {
        0 => swap(random, &mut certificate.joints),
        1 => {
            certificate.pairs.pop();
        }
        2 => certificate.pairs.reverse(),
        3 => {
            if let Some(pair) = pick(random, &mut certificate.pairs).cloned() {
                certificate.pairs.push(pair);
            }
        }
        4 => certificate.tolerance = certificate.tolerance.map(|t| alter(random, t)),
        5 => {
            "clearance certificate 1".clone_into(&mut certificate.format);
            (certificate.parts, certificate.tolerance) = (None, None);
        }
        6 => {
            if let Some(parts) = &mut certificate.parts {
                parts.links[0].2 += 0.1;
            }
        }
        _ => certificate.model = "0".repeat(64),
    }
}

fn altered(random: &mut Random, base: &Certificate) -> Certificate {
    let mut certificate = base.clone();
    for _ in 0..=random.below(3) {
        let (pairs, joints) = (certificate.pairs.len(), certificate.joints.len());
        match random.below(20) {
            0..=3 => alter_segments(random, &mut certificate),
            4..=11 => {
                if let Some(segment) = pick(random, &mut certificate.segments) {
                    alter_motion(random, &mut segment.motion, joints);
                }
            }
            12..=17 => {
                if let Some(segment) = pick(random, &mut certificate.segments) {
                    alter_proofs(random, &mut segment.proofs, pairs);
                }
            }
            _ => alter_rest(random, &mut certificate),
        }
    }
    resign(&mut certificate);
    certificate
}

/// Tolerance for the same motion: a little more than the verifier takes for rounding.
fn is_same_motion(a: &Certificate, b: &Certificate) -> Result<(), String> {
    if a.segments.len() != b.segments.len() {
        return Err("another number of segments".to_owned());
    }
    for (a, b) in a.segments.iter().zip(&b.segments).map(|(a, b)| (&a.motion, &b.motion)) {
        let near = |x: &f64, y: &f64| (x - y).abs() <= 4e-9 * (1.0 + y.abs());
        let all_near = |x: &[f64], y: &[f64]| x.len() == y.len() && x.iter().zip(y).all(|(x, y)| near(x, y));
        let lists = [(&a.from, &b.from), (&a.to, &b.to)];
        let same_ends = lists.iter().all(|(x, y)| match (x, y) {
            (Some(x), Some(y)) => all_near(x, y),
            (x, y) => x.is_none() && y.is_none(),
        });
        let flat = |t: &SegmentText| t.polynomials.clone().unwrap_or_default().concat();
        let tube = |t: &SegmentText| t.tube.iter().filter(|t| **t != 0.0).copied().collect::<Vec<_>>();
        let movers = |t: &SegmentText| {
            let numbers = |o: &MovingObstacle| {
                let (xyz, q) = o.start.unwrap_or(([0.0; 3], [0.0, 0.0, 0.0, 1.0]));
                [&o.centre[..], &o.linear, &o.angular, &xyz, &q].concat()
            };
            t.obstacles.iter().flat_map(numbers).collect::<Vec<_>>()
        };
        if !(same_ends && all_near(&flat(a), &flat(b))) {
            return Err(format!("another motion: {a:?}, expected {b:?}"));
        }
        if tube(a) != tube(b) {
            return Err("another tube".to_owned());
        }
        if !all_near(&movers(a), &movers(b)) {
            return Err("other obstacles".to_owned());
        }
    }
    Ok(())
}

/// Verifies one altered document: the fault of the answers, and whether it was accepted as any motion and as the expected one.
fn answers(base: &Base, verifier: &Verifier, room: &Room, seed: u64) -> (Option<String>, [bool; 2]) {
    let mut random = Random::new(seed);
    let document = altered(&mut random, &base.certificate);
    let any = verifier.verify(&document);
    let expected = base.motion.as_ref().map(|motion| {
        let tolerance = base.certificate.tolerance;
        let expected =
            ExpectedMotion { motion: Some(motion.clone()), tolerance, ..ExpectedMotion::default() };
        verifier.verify_expected(&document, &expected)
    });
    let is_expected = expected.is_some_and(|found| found.is_ok());
    let found = [any.is_ok(), is_expected];
    if any.is_ok() || is_expected {
        if let Some(touch) = room.touch(&document, &mut random) {
            return (Some(format!("accepted, but {touch}")), found);
        }
        let read = Certificate::from_json(&document.to_json());
        if read.as_ref().ok() != Some(&document) {
            return (Some(format!("it is another one once it is written: {:?}", read.err())), found);
        }
    }
    if is_expected {
        let other = is_same_motion(&document, &base.certificate).err();
        let tolerance = document.tolerance == base.certificate.tolerance;
        return (other.or_else(|| (!tolerance).then(|| "another tolerance".to_owned())), found);
    }
    (None, found)
}

#[test]
fn what_is_accepted_is_free_and_expected() {
    let bases = bases();
    let count = share(3_000, 100_000) / bases.len() + 1;
    let mut all_accepted = [0; 2];
    for (number, base) in bases.iter().enumerate() {
        let Scene { robot, world, settings, .. } = &base.scene;
        let verifier = Verifier::new(robot, world, settings, None).unwrap();
        let room = Room::new(&base.scene, &base.certificate.pairs);
        if base.motion.is_some() {
            assert_eq!(room.touch(&base.certificate, &mut Random::new(1)), None, "{}", base.name);
        } else {
            assert!(room.touch(&base.certificate, &mut Random::new(1)).is_some(), "{}", base.name);
        }
        let found: Vec<(Option<String>, [bool; 2])> = (0..count)
            .into_par_iter()
            .map(|i| answers(base, &verifier, &room, (number * 10_000_000 + i) as u64))
            .collect();
        let accepted = [0, 1].map(|i| found.iter().filter(|(_, accepted)| accepted[i]).count());
        println!("{}: {count} altered, {accepted:?} accepted as any and as the expected motion", base.name);
        all_accepted = [0, 1].map(|i| all_accepted[i] + accepted[i]);
        let wrong =
            found.into_iter().enumerate().filter_map(|(i, (wrong, _))| Some(format!("{i}: {}", wrong?)));
        let mut tally = Tally::new(&format!("altered certificates: {}", base.name));
        tally.add_all(count, wrong.collect());
        tally.finish(count);
    }
    let many = count * bases.len() / 50;
    assert!(all_accepted.iter().all(|n| *n > many), "too few are accepted to tell: {all_accepted:?}");
}

/// Whatever a text holds: an answer, and no panic.
#[test]
fn broken_texts_get_a_response() {
    let base = followers().into_iter().next().unwrap();
    let text = base.certificate.to_json();
    let scene = &base.scene;
    let verifier = Verifier::new(&scene.robot, &scene.world, &scene.settings, None).unwrap();
    let junk = [
        "",
        "null",
        "1e999",
        "-",
        "[[[[",
        "\"\\u0000\"",
        "{}",
        "9999999999999999999999",
        "1e308",
        "[]",
        "\u{1b}[2J",
    ];
    let mut random = Random::new(3);
    let read = |text: &str| {
        if let Ok(mut certificate) = serde_json::from_str::<Certificate>(text) {
            let _ = verifier.verify(&certificate);
            resign(&mut certificate);
            let _ = verifier.verify(&certificate);
        }
    };
    for _ in 0..share(3_000, 100_000) {
        let length = u32::try_from(text.len()).unwrap();
        let [from, to] = [(); 2].map(|()| random.below(length) as usize);
        let (from, to) = (
            from,
            if random.below(2) == 0 { (from + random.below(12) as usize).min(text.len()) } else { to },
        );
        let new = junk[random.below(u32::try_from(junk.len()).unwrap()) as usize];
        let broken = [&text[..from], new, text.get(to..).unwrap_or_default()].concat();
        read(&broken);
    }
    let deep = format!("{}{}", "[".repeat(1_000_000), "]".repeat(1_000_000));
    read(&deep);
    read(&text.replacen("\"segments\":[", &format!("\"segments\":[{deep},"), 1));
}
