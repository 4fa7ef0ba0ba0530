//! Tests of the PCD reader: every form of storage, cut or altered files, and faults.

use proptest::prelude::*;

use super::*;
use crate::read_cloud;

/// Name, kind, bytes of a number, count.
type Field = (&'static str, char, usize, usize);

/// A cloud in any of the three encodings: x, y and z among other fields, in any order and of any kind.
#[derive(Clone, Debug)]
struct Written {
    points: Vec<[f64; 3]>,
    /// Names, kinds and counts.
    fields: Vec<Field>,
    form: &'static str,
}

impl Written {
    fn file(&self) -> Vec<u8> {
        let list =
            |word: &dyn Fn(&Field) -> String| self.fields.iter().map(word).collect::<Vec<_>>().join(" ");
        let mut bytes = format!(
            "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT {}\n\
             WIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA {}\n",
            list(&|f| f.0.to_owned()),
            list(&|f| f.2.to_string()),
            list(&|f| f.1.to_string()),
            list(&|f| f.3.to_string()),
            self.points.len(),
            self.points.len(),
            self.form
        )
        .into_bytes();
        match self.form {
            "ascii" => {
                for i in 0..self.points.len() {
                    let words = self.fields.iter().flat_map(|f| vec![self.number(i, f.0).to_string(); f.3]);
                    bytes.extend(words.collect::<Vec<_>>().join(" ").into_bytes());
                    bytes.push(b'\n');
                }
            }
            "binary" => {
                for i in 0..self.points.len() {
                    bytes.extend(self.fields.iter().flat_map(|f| self.encoded(i, f)));
                }
            }
            _ => {
                let kept = self.fields.iter().filter(|f| f.0 != "_");
                let plain: Vec<u8> =
                    kept.flat_map(|f| (0..self.points.len()).flat_map(move |i| self.encoded(i, f))).collect();
                let packed = lzf::pack(&plain);
                bytes.extend(u32::try_from(packed.len()).unwrap().to_le_bytes());
                bytes.extend(u32::try_from(plain.len()).unwrap().to_le_bytes());
                bytes.extend(packed);
            }
        }
        bytes
    }

    fn number(&self, i: usize, name: &str) -> f64 {
        match ["x", "y", "z"].iter().position(|&n| n == name) {
            Some(k) => self.points[i][k],
            None => 7.0,
        }
    }

    fn encoded(&self, i: usize, &(name, kind, size, count): &Field) -> Vec<u8> {
        let number = self.number(i, name);
        let one = match (kind, size) {
            ('F', 4) => (number as f32).to_le_bytes().to_vec(),
            ('F', 8) => number.to_le_bytes().to_vec(),
            ('I', 2) => (number as i16).to_le_bytes().to_vec(),
            ('U', 1) => vec![number as u8],
            ('U', 4) => (number as u32).to_le_bytes().to_vec(),
            _ => (number as i32).to_le_bytes().to_vec(),
        };
        one.repeat(count)
    }
}

fn written() -> impl Strategy<Value = Written> {
    // integers are the same in every kind
    let number = || (-100i8..100).prop_map(f64::from);
    let kind = || prop_oneof![Just(('F', 4)), Just(('F', 8)), Just(('I', 2)), Just(('I', 4))];
    let points = prop::collection::vec([number(), number(), number()], 0..20);
    let others =
        Just(vec![("intensity", 'F', 4, 1), ("rgb", 'U', 4, 1), ("_", 'U', 1, 5), ("normal", 'F', 4, 3)]);
    let form = prop_oneof![Just("ascii"), Just("binary"), Just("binary_compressed")];
    (points, [kind(), kind(), kind()], others, form).prop_flat_map(|(points, kinds, others, form)| {
        let mut fields = others;
        fields
            .extend(["x", "y", "z"].into_iter().zip(kinds).map(|(name, (kind, size))| (name, kind, size, 1)));
        Just(fields).prop_shuffle().prop_map(move |fields| Written { points: points.clone(), fields, form })
    })
}

proptest! {
    #[test]
    fn every_form_gives_the_points_back(written in written()) {
        let cloud = read_cloud(&written.file()).unwrap();
        let points: Vec<_> = cloud.points.iter().map(|p| p.map(f64::from)).collect();
        prop_assert_eq!(points, written.points);
        prop_assert!(cloud.dropped == 0 && cloud.rounding == 0.0 && cloud.remarks.is_empty());
    }

    #[test]
    fn cut_or_altered_files_never_panic(written in written(), flips in prop::collection::vec(any::<(u16, u8)>(), 1..6)) {
        let bytes = written.file();
        for end in 0..bytes.len() {
            let cut = read_cloud(&bytes[..end]);
            // a header of zero points is complete early; and a last number in text may lose digits and still be a number
            let complete = written.points.is_empty() || written.form == "ascii";
            prop_assert!(cut.is_err() || complete, "{} of {}", end, bytes.len());
        }
        let mut altered = bytes;
        for &(at, bits) in &flips {
            let at = usize::from(at) % altered.len();
            altered[at] ^= bits;
        }
        let _ = read_cloud(&altered);
    }
}

const HEAD: &str = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";

#[test]
fn points_that_are_no_numbers_are_dropped() {
    let text = format!(
        "# .PCD v0.7\nVERSION 0.7\n{HEAD}WIDTH 2\nHEIGHT 2\nPOINTS 4\nDATA ascii\n\
                        1 2 3\nnan nan nan\n\n4 5 NaN\n0.1 0.2 0.3\n"
    );
    let cloud = read_cloud(text.as_bytes()).unwrap();
    assert_eq!(cloud.points, [[1.0, 2.0, 3.0], [0.1, 0.2, 0.3]]);
    // a 32-bit number as text is rounded only once, to the number of the sensor
    assert_eq!((cloud.dropped, cloud.rounding), (2, 0.0));
}

#[test]
fn the_viewpoint_is_reported_and_not_applied() {
    let text = format!(
        "VERSION 0.7\r\n{HEAD}WIDTH 1\r\nHEIGHT 1\r\nVIEWPOINT 0 0 1 1 0 0 0\r\nDATA ascii\r\n1 2 3\r\n"
    );
    let cloud = read_cloud(text.as_bytes()).unwrap();
    assert_eq!(cloud.points, [[1.0, 2.0, 3.0]]);
    assert!(cloud.remarks[0].contains("VIEWPOINT"));
}

#[test]
fn more_points_than_announced_are_rejected() {
    let fields = vec![("x", 'F', 4, 1), ("y", 'F', 4, 1), ("z", 'F', 4, 1)];
    for form in ["ascii", "binary", "binary_compressed"] {
        for count in [0, 1, 3] {
            let points = vec![[1.0, 2.0, 3.0]; count];
            let file = Written { points, fields: fields.clone(), form }.file();
            let with = |more: &[u8]| read_cloud(&[&file[..], more].concat());
            let more: [&[u8]; 4] = [b"0.5 0.5 0.5\n", b"x", &[1; 12], &[0, 0, 128, 63]];
            for more in more {
                let message = with(more).unwrap_err().to_string();
                let words = format!("after the {count} points that its header announces");
                assert!(message.contains(&words), "{form}: {message}");
            }
            for blank in [&b"\n"[..], b" \r\n\n"] {
                let cloud = with(blank).unwrap();
                assert_eq!(cloud.points.len(), count, "{form}");
                assert_eq!(cloud.remarks.len(), usize::from(form != "ascii"), "{:?}", cloud.remarks);
            }
            // as the Point Cloud Library fills up pages
            if form != "ascii" {
                let cloud = with(&[0; 4096]).unwrap();
                assert!(
                    cloud.remarks[0].starts_with("4096 bytes follow the last point"),
                    "{:?}",
                    cloud.remarks
                );
                assert!(with(&vec![0; LONGEST_PADDING + 1]).is_err());
            }
        }
    }
}

#[test]
fn lines_of_the_header_stand_once() {
    let header = [
        "VERSION 0.7",
        "FIELDS x y z",
        "SIZE 4 4 4",
        "TYPE F F F",
        "COUNT 1 1 1",
        "WIDTH 1",
        "HEIGHT 1",
        "VIEWPOINT 0 0 0 1 0 0 0",
        "POINTS 1",
    ];
    let text = |lines: &[&str]| format!("{}\nDATA ascii\n1 2 3\n", lines.join("\n"));
    assert_eq!(read_cloud(text(&header).as_bytes()).unwrap().points, [[1.0, 2.0, 3.0]]);
    for line in header.into_iter().chain(["COLUMNS y x z"]) {
        let message = read_cloud(text(&[&header[..], &[line]].concat()).as_bytes()).unwrap_err().to_string();
        let key = line.split(' ').next().unwrap().replace("COLUMNS", "FIELDS");
        assert!(message.contains(&format!("{key} twice")), "{message}");
    }
    let comments = [&["# a", "# a"][..], &header].concat();
    assert!(read_cloud(text(&comments).as_bytes()).is_ok());
    let two = text(&header).replace("WIDTH 1", "WIDTH 1 2");
    assert!(read_cloud(two.as_bytes()).unwrap_err().to_string().contains("WIDTH has 2 values"));
}

#[test]
fn faults_are_named() {
    for (text, word) in [
        ("VERSION 0.7\nDATA ascii\n".to_owned(), "POINTS"),
        (format!("{HEAD}POINTS 1\n"), "DATA"),
        (format!("{HEAD}POINTS 1\nDATA zipped\n"), "zipped"),
        (format!("{HEAD}POINTS two\nDATA ascii\n"), "two"),
        (format!("{HEAD}WIDTH 2\nHEIGHT 2\nPOINTS 3\nDATA ascii\n"), "POINTS is 3"),
        (format!("{HEAD}HEIGHT 2\nDATA ascii\n"), "WIDTH"),
        (format!("{HEAD}POINTS 2\nDATA ascii\n1 2 3\n"), "after 1 of 2"),
        (format!("{HEAD}POINTS 1\nDATA ascii\n1 2\n"), "2 numbers"),
        (format!("{HEAD}POINTS 1\nDATA ascii\n1 two 3\n"), "y is 'two'"),
        (format!("{HEAD}POINTS 4000000000\nDATA binary\n"), "48000000000"),
        (format!("{HEAD}POINTS {}\nDATA binary\n", usize::MAX), "counted"),
        (format!("{HEAD}POINTS 4000000000\nDATA ascii\n"), "after 0"),
        (format!("{HEAD}POINTS 1\nDATA binary_compressed\nabc"), "compressed"),
        ("FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 1\nDATA ascii\n1 2\n".to_owned(), "z once"),
        ("FIELDS x y z\nSIZE 4 4\nPOINTS 0\nDATA ascii\n".to_owned(), "SIZE"),
        ("FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 0\nDATA ascii\n".to_owned(), "field z"),
        (format!("FIELDS x y z\nCOUNT 1 1 {}\nPOINTS 1\nDATA binary\n", usize::MAX), "counted"),
        ("POINT CLOUD".to_owned(), "neither"),
    ] {
        let error = read_cloud(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(word), "{error} does not name {word}");
    }
}
