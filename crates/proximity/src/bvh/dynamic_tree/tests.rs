//! Tests of the dynamic bounding box tree: random edits, searches for overlapping boxes, and unbounded boxes.

use clearance_geometry::math::Point;
use proptest::prelude::*;

use super::*;

fn axis_box() -> impl Strategy<Value = AxisBox> {
    let point = prop::array::uniform3(-2.0..2.0_f64);
    (point, 0.0..0.7_f64).prop_map(|(p, radius)| AxisBox::around([Point::from(p)], radius))
}

#[derive(Clone, Debug)]
enum Edit {
    Set(u32, AxisBox),
    Remove(u32),
}

fn edits() -> impl Strategy<Value = Vec<Edit>> {
    let item = 0..200_u32;
    let set = (item.clone(), axis_box()).prop_map(|(item, bounds)| Edit::Set(item, bounds));
    prop::collection::vec(prop_oneof![3 => set, 1 => item.prop_map(Edit::Remove)], 1..600)
}

fn overlap(a: &AxisBox, b: &AxisBox) -> bool {
    (0..3).all(|i| a.lo[i] <= b.hi[i] && b.lo[i] <= a.hi[i])
}

/// Checks the whole content of a tree: every box is within its ancestors' boxes, and every item occurs exactly once.
fn assert_holds(tree: &DynamicTree, expected: &[Option<AxisBox>]) {
    let mut seen = vec![None; expected.len()];
    let mut stack: Vec<(u32, Option<AxisBox>)> = tree.nodes.first().map(|_| (0, None)).into_iter().collect();
    while let Some((number, bounds)) = stack.pop() {
        let node = &tree.nodes[number as usize];
        for lane in 0..LANES {
            let own = node.boxes.lane(lane);
            if let Some(bounds) = bounds {
                assert_eq!(bounds.union(&own), bounds);
            }
            match node.children[lane] {
                Child::Nothing => assert_eq!(own, AxisBox::EMPTY),
                Child::Item(item) => assert!(seen[item as usize].replace(own).is_none()),
                Child::Node(child) => stack.push((child, Some(own))),
            }
        }
    }
    assert_eq!(seen, expected);
    assert_eq!(tree.len(), expected.iter().flatten().count());
}

proptest! {
    #[test]
    fn edits_leave_what_they_say(edits in edits(), with in axis_box()) {
        let mut tree = DynamicTree::default();
        let mut expected = vec![None; 200];
        for edit in edits {
            match edit {
                Edit::Set(item, bounds) => {
                    tree.set(item, bounds);
                    expected[item as usize] = Some(bounds);
                }
                Edit::Remove(item) => {
                    tree.remove(item);
                    expected[item as usize] = None;
                }
            }
        }
        assert_holds(&tree, &expected);
        let (mut stack, mut found) = (Vec::new(), Vec::new());
        for level in [Level::new(), clearance_geometry::simd::baseline()] {
            found.clear();
            tree.overlapping(level, &with, &mut stack, &mut found);
            found.sort_unstable();
            let all = (0..200_u32).filter(|i| expected[*i as usize].is_some_and(|b| overlap(&b, &with)));
            prop_assert_eq!(&found, &all.collect::<Vec<_>>());
        }
    }

    #[test]
    fn eight_boxes_find_what_each_finds_alone(
        boxes in prop::collection::vec(axis_box(), 0..300),
        asked in prop::array::uniform8(axis_box()),
        among in any::<u8>(),
    ) {
        let tree = DynamicTree::build(&(0..).zip(boxes.iter().copied()).collect::<Vec<_>>());
        let mut eight = EightBoxes::EMPTY;
        for (lane, bounds) in asked.iter().enumerate() {
            eight.set(lane, bounds);
        }
        let bits = |item: &AxisBox| {
            let bit = |lane: usize| u8::from(overlap(item, &asked[lane])) << lane;
            among & (0..LANES).fold(0, |all, lane| all | bit(lane))
        };
        let expected: Vec<_> = (0..).zip(boxes.iter().map(bits)).filter(|(_, bits)| *bits != 0).collect();
        for level in [Level::new(), clearance_geometry::simd::baseline()] {
            let (mut stack, mut found) = (Vec::new(), Vec::new());
            dispatch!(level, simd => tree.find_overlapping_any(simd, SelectedBoxes { boxes: &eight, mask: among }, &mut stack, &mut found));
            found.sort_unstable();
            prop_assert_eq!(&found, &expected);
        }
    }
}

#[test]
fn unbounded_boxes_are_near_everything() {
    let mut tree = DynamicTree::default();
    tree.set(0, AxisBox::ALL);
    tree.set(1, AxisBox::around([Point::new(f64::NAN, 0.0, 0.0)], 0.1));
    let mut found = Vec::new();
    let with = AxisBox::around([Point::new(5.0, 0.0, 0.0)], 0.1);
    tree.overlapping(Level::new(), &with, &mut Vec::new(), &mut found);
    assert_eq!(found, [0, 1]);
}
