//! Tests of octrees: decoding and encoding, file headers, voxels, unknown space, damaged files.

use proptest::prelude::*;

use super::*;

/// A tree as written in a test.
#[derive(Clone, Debug)]
enum Node {
    Unknown,
    Leaf(bool),
    Inner(Box<[Node; 8]>),
}

impl Node {
    fn binary(&self) -> Vec<u8> {
        let Self::Inner(children) = self else { return vec![] };
        let mut word = 0u16;
        for (i, child) in children.iter().enumerate() {
            let code = match child {
                Self::Unknown => 0,
                Self::Leaf(occupied) => 1 + u16::from(*occupied),
                Self::Inner(_) => 3,
            };
            word |= code << (2 * i);
        }
        let mut bytes = word.to_le_bytes().to_vec();
        bytes.extend(children.iter().flat_map(Self::binary));
        bytes
    }

    fn full(&self, colour: bool) -> Vec<u8> {
        let value: f32 = match self {
            Self::Leaf(false) => -0.4,
            _ => 0.85,
        };
        let mut bytes = value.to_le_bytes().to_vec();
        bytes.extend(colour.then_some([9, 8, 7]).into_iter().flatten());
        let Self::Inner(children) = self else {
            bytes.push(0);
            return bytes;
        };
        let exists = |(i, child): (usize, &Self)| u8::from(!matches!(child, Self::Unknown)) << i;
        bytes.push(children.iter().enumerate().map(exists).sum());
        let known = children.iter().filter(|c| !matches!(c, Self::Unknown));
        bytes.extend(known.flat_map(|c| c.full(colour)));
        bytes
    }

    fn count(&self) -> usize {
        match self {
            Self::Unknown => 0,
            Self::Leaf(_) => 1,
            Self::Inner(children) => 1 + children.iter().map(Self::count).sum::<usize>(),
        }
    }

    /// The content of a finest cell, found by descending the tree.
    fn at(&self, cell: [u16; 3], level: u8) -> Space {
        match self {
            Self::Unknown => Space::Unknown,
            Self::Leaf(occupied) => {
                if *occupied {
                    Space::Occupied
                } else {
                    Space::Free
                }
            }
            Self::Inner(children) => {
                let bit = |k: usize| usize::from(cell[k] >> (level - 1) & 1);
                children[bit(0) + 2 * bit(1) + 4 * bit(2)].at(cell, level - 1)
            }
        }
    }
}

fn tree() -> impl Strategy<Value = Node> {
    let leaf = prop_oneof![Just(Node::Unknown), any::<bool>().prop_map(Node::Leaf)];
    let inner = leaf.prop_recursive(4, 60, 8, |child| prop::collection::vec(child, 8).prop_map(inner_node));
    prop::collection::vec(inner, 8).prop_map(inner_node)
}

/// A node with known children: a node without children is a leaf.
fn inner_node(mut children: Vec<Node>) -> Node {
    if children.iter().all(|c| matches!(c, Node::Unknown)) {
        children[3] = Node::Leaf(false);
    }
    Node::Inner(Box::new(children.try_into().unwrap()))
}

/// A chain of inner nodes with one leaf at the end, a given number of levels down.
fn chain(levels: u8, octant: usize) -> Node {
    (0..levels).fold(Node::Leaf(true), |inner, _| {
        let mut children = std::array::from_fn(|_| Node::Unknown);
        children[octant] = inner;
        Node::Inner(Box::new(children))
    })
}

fn bt_file(tree: &Node, resolution: f64) -> Vec<u8> {
    let header = format!(
        "# Octomap OcTree binary file\n# (a comment)\n#\nid OcTree\nsize {}\nres {resolution}\ndata\n",
        tree.count()
    );
    [header.as_bytes(), &tree.binary()].concat()
}

fn ot_file(tree: &Node, id: &str) -> Vec<u8> {
    let header = format!("# Octomap OcTree file\nid {id}\nsize {}\nres 0.05\ndata\n", tree.count());
    [header.as_bytes(), &tree.full(id == "ColorOcTree")].concat()
}

fn space_at(map: &Octomap, cell: [u16; 3]) -> Vec<Space> {
    let holds = |c: &&Cell| {
        let [lo, hi] = c.bounds();
        (0..3).all(|k| (lo[k]..hi[k]).contains(&u32::from(cell[k])))
    };
    map.cells().iter().filter(holds).map(|c| c.space).collect()
}

proptest! {
    #[test]
    fn every_encoding_gives_the_same_partition(tree in tree(), cells in prop::collection::vec(any::<[u16; 3]>(), 20)) {
        let map = Octomap::from_binary(0.05, &tree.binary()).unwrap();
        let full = Octomap::from_full(0.05, "OcTree", &tree.full(false)).unwrap();
        let colour = Octomap::from_full(0.05, "ColorOcTree", &tree.full(true)).unwrap();
        for cell in cells {
            // exactly one cell of the partition contains it
            prop_assert_eq!(space_at(&map, cell), vec![tree.at(cell, LEVELS)]);
            prop_assert_eq!(space_at(&full, cell), vec![tree.at(cell, LEVELS)]);
        }
        prop_assert_eq!(&full, &colour);
        prop_assert_eq!(full.cells().len(), map.cells().len());
        prop_assert_eq!(&map, &Octomap::from_file(&bt_file(&tree, 0.05)).unwrap());
        prop_assert_eq!(&full, &Octomap::from_file(&ot_file(&tree, "OcTree")).unwrap());
        prop_assert_eq!(&full, &Octomap::from_file(&ot_file(&tree, "ColorOcTree")).unwrap());
    }

    #[test]
    fn an_encoded_tree_is_the_tree_it_came_from(tree in tree()) {
        let map = Octomap::from_binary(0.05, &tree.binary()).unwrap();
        prop_assert_eq!(map.to_binary(false), tree.binary());
        let full = Octomap::from_full(0.05, "ColorOcTree", &tree.full(true)).unwrap();
        prop_assert_eq!(full.to_binary(false), tree.binary());
    }

    #[test]
    fn unknown_space_that_is_occupied_is_encoded_as_occupied(tree in tree()) {
        let map = Octomap::from_binary(0.05, &tree.binary()).unwrap();
        let filled = Octomap::from_binary(0.05, &map.to_binary(true)).unwrap();
        let cubes = |map: &Octomap, unknown_is_occupied| {
            let voxels = map.to_voxels(unknown_is_occupied).unwrap();
            let cubes = voxels.iter().flat_map(|voxels| voxels.cubes());
            let mut cubes: Vec<[u32; 4]> = cubes
                .map(|cube| [cube.centre[0], cube.centre[1], cube.centre[2], cube.half_edge].map(f32::to_bits))
                .collect();
            cubes.sort_unstable();
            cubes
        };
        prop_assert_eq!(cubes(&filled, false), cubes(&map, true));
    }

    #[test]
    fn cut_or_altered_files_never_panic(tree in tree(), flips in prop::collection::vec(any::<(u16, u8)>(), 1..6)) {
        for bytes in [bt_file(&tree, 0.1), ot_file(&tree, "OcTree"), ot_file(&tree, "ColorOcTree")] {
            for end in 0..bytes.len() {
                prop_assert!(Octomap::from_file(&bytes[..end]).is_err(), "{} of {} bytes", end, bytes.len());
            }
            let mut altered = bytes;
            for &(at, bits) in &flips {
                let at = usize::from(at) % altered.len();
                altered[at] ^= bits;
            }
            if let Ok(map) = Octomap::from_file(&altered) {
                let _ = map.to_voxels(true);
            }
        }
    }

    #[test]
    fn voxels_hold_their_cells(tree in tree(), resolution in 0.001..1.0) {
        let map = Octomap::from_binary(resolution, &tree.binary()).unwrap();
        let occupied: Vec<_> = map.cells().iter().filter(|c| c.space == Space::Occupied).collect();
        let voxels = map.to_voxels(false).unwrap();
        prop_assert_eq!(voxels.as_ref().map_or(0, |v| v.cubes().len()), occupied.len());
        for (cell, cube) in occupied.iter().zip(voxels.iter().flat_map(|v| v.cubes())) {
            let [lo, hi] = map.corners(**cell);
            let half = f64::from(cube.half_edge);
            let farthest = cube.centre.map(f32::abs).into_iter().fold(0.0, f32::max);
            for k in 0..3 {
                let centre = f64::from(cube.centre[k]);
                prop_assert!(centre - half <= lo[k] && hi[k] <= centre + half);
                prop_assert!(2.0 * half <= (hi[k] - lo[k]) + 1e-6 * (1.0 + f64::from(farthest)));
            }
        }
    }

    #[test]
    fn unknown_pieces_are_the_unknown_space_near_what_is_known(tree in tree(), cells in prop::collection::vec(any::<[u16; 3]>(), 30)) {
        let map = Octomap::from_binary(0.05, &tree.binary()).unwrap();
        let pieces = map.unknown_cells();
        let known = map.cells().iter().filter(|c| c.space != Space::Unknown).map(|c| c.bounds());
        let Some([lo, hi]) = known.reduce(|a, b| {
            [[0, 1, 2].map(|k| a[0][k].min(b[0][k])), [0, 1, 2].map(|k| a[1][k].max(b[1][k]))]
        }) else {
            prop_assert!(pieces.is_empty());
            return Ok(());
        };
        for cell in cells {
            let inside = (0..3).all(|k| (lo[k]..hi[k]).contains(&u32::from(cell[k])));
            let found = pieces.iter().filter(|c| {
                let [lo, hi] = c.bounds();
                (0..3).all(|k| (lo[k]..hi[k]).contains(&u32::from(cell[k])))
            }).count();
            let unknown = tree.at(cell, LEVELS) == Space::Unknown;
            prop_assert!(found == usize::from(unknown) || !inside && found <= usize::from(unknown));
        }
    }
}

#[test]
fn a_finest_cell_lies_where_octomap_puts_it() {
    // octant 7 of the root begins at the origin; below it always the lowest octant
    let mut tree = chain(15, 0);
    let mut children = std::array::from_fn(|_| Node::Unknown);
    std::mem::swap(&mut children[7], &mut tree);
    let map = Octomap::from_binary(0.05, &Node::Inner(Box::new(children)).binary()).unwrap();
    let voxels = map.to_voxels(false).unwrap().unwrap();
    assert_eq!(voxels.cubes().len(), 1);
    let cube = voxels.cubes()[0];
    for c in cube.centre {
        assert!((c - 0.025).abs() < 1e-8, "{cube:?}");
    }
    assert!((cube.half_edge - 0.025).abs() < 1e-8);
}

#[test]
fn a_tree_of_one_leaf_or_of_none_is_encoded() {
    let leaf = Octomap::from_full(0.1, "OcTree", &Node::Leaf(true).full(false)).unwrap();
    assert_eq!(leaf.to_binary(false), 0xaaaa_u16.to_le_bytes());
    let none = Octomap::from_binary(0.1, &[]).unwrap();
    assert_eq!((none.to_binary(false), none.to_binary(true)), (vec![], vec![]));
}

#[test]
fn faults_name_the_byte() {
    let deep = |levels| Octomap::from_binary(0.1, &chain(levels, 3).binary());
    assert!(deep(16).is_ok());
    assert_eq!(deep(17), Err(OctomapError::TooDeep { byte: 32 }));
    assert_eq!(
        Octomap::from_full(0.1, "OcTree", &chain(17, 3).full(false)),
        Err(OctomapError::TooDeep { byte: 80 })
    );
    assert_eq!(Octomap::from_binary(0.1, &[3, 0, 1]), Err(OctomapError::Truncated { byte: 2 }));
    assert_eq!(Octomap::from_binary(0.1, &[1, 0, 1]), Err(OctomapError::Trailing { byte: 2, count: 1 }));
    let nan = [&f32::NAN.to_le_bytes()[..], &[0]].concat();
    assert_eq!(Octomap::from_full(0.1, "OcTree", &nan), Err(OctomapError::NoNumber { byte: 0 }));
    assert!(matches!(Octomap::from_full(0.1, "CountingOcTree", &nan), Err(OctomapError::UnknownType(_))));
    for resolution in [0.0, -0.1, f64::NAN, 1e9, 1e-300] {
        assert!(matches!(Octomap::from_binary(resolution, &[]), Err(OctomapError::BadResolution(_))));
    }
}

#[test]
fn headers_are_read_as_octomap_does() {
    let tree = chain(2, 5);
    let mut old = vec![3, 0, 0, 0];
    old.extend(0.25f64.to_le_bytes());
    old.extend(3u32.to_le_bytes());
    old.extend(tree.binary());
    let map = Octomap::from_bt_file(&old).unwrap();
    assert_eq!(map, Octomap::from_file(&bt_file(&tree, 0.25)).unwrap());
    let text = |text: &str| Octomap::from_file(text.as_bytes());
    assert_eq!(text("hello"), Err(OctomapError::NoOctomap));
    let start = "# Octomap OcTree binary file\n";
    assert_eq!(text(start), Err(OctomapError::Incomplete("data")));
    assert_eq!(text(&format!("{start}res 0.1\nres 0.2\n")), Err(OctomapError::Contradiction("res")));
    assert!(matches!(text(&format!("{start}res 0.1 x\n")), Err(OctomapError::BadHeader { key: "res", .. })));
    assert_eq!(text(&format!("{start}res 0.1\nsize 1\ndata\n")), Err(OctomapError::Incomplete("id")));
    assert!(matches!(text(&format!("{start}res x\n")), Err(OctomapError::BadHeader { key: "res", .. })));
    let wrong = String::from_utf8(bt_file(&tree, 0.25)).unwrap().replace("size 3", "size 4");
    assert_eq!(text(&wrong), Err(OctomapError::WrongSize { announced: 4, found: 3 }));
    // no nodes, no bytes
    let empty = text(&format!("{start}id OcTree\nsize 0\nres 0.1\ndata\n")).unwrap();
    assert_eq!(empty.to_voxels(true).unwrap(), None);
}
