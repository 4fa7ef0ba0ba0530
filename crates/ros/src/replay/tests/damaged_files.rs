//! Tests of the replay of recordings that are cut off or damaged.

use clearance_geometry::testing::Random;

use super::*;

#[test]
fn a_file_that_is_cut_off_is_run_as_far_as_it_goes_and_a_broken_one_is_rejected() {
    let folder = tempfile::tempdir().unwrap();
    let mut cell = Cell::start(folder.path());
    run(&mut cell);
    cell.end();
    let whole = std::fs::read(folder.path().join("record.mcap")).unwrap();
    let file = folder.path().join("other.mcap");
    let (mut some, mut most) = (0, 0);
    for length in (0..whole.len()).step_by(whole.len() / 40).chain([whole.len() - 1]) {
        std::fs::write(&file, &whole[..length]).unwrap();
        if let Ok(outcome) = again(&file) {
            assert_eq!(outcome.difference, None, "cut off after {length} bytes");
            some += 1;
            most = most.max(outcome.same);
        }
    }
    assert!(some > 0);
    assert_eq!(most, ANSWERS, "what was written is not lost with the end of the file");
    let mut random = Random::new(1);
    for _ in 0..60 {
        let mut broken = whole.clone();
        for _ in 0..=random.below(3) {
            let at = random.below(broken.len());
            broken[at] = random.bits().to_le_bytes()[0];
        }
        std::fs::write(&file, broken).unwrap();
        // the result does not matter: it must neither panic nor run without end
        let _ = again(&file);
    }
    for (bytes, word) in [
        (&b""[..], "no beginning"),
        (b"hello, this is no MCAP file at all", "no MCAP file"),
        // a record of 2^60 bytes
        (b"\x89MCAP0\r\n\x01\x00\x00\x00\x00\x00\x00\x00\x10abc", "damaged"),
        // a record of 500 MiB, of which 30 bytes are there
        (include_bytes!("../../../../../fuzz/corpus/recording/record_length.mcap"), "no beginning"),
        (
            include_bytes!("../../../../../fuzz/corpus/recording/text_longer_than_record.mcap"),
            "lengths in it",
        ),
        (
            include_bytes!("../../../../../fuzz/corpus/recording/metadata_longer_than_record.mcap"),
            "lengths in it",
        ),
        (
            include_bytes!("../../../../../fuzz/corpus/recording/attachment_without_checksum.mcap"),
            "lengths in it",
        ),
        // a record that is longer than its chunk
        (include_bytes!("../../../../../fuzz/corpus/recording/record_beyond_chunk.mcap"), "damaged"),
    ] {
        std::fs::write(&file, bytes).unwrap();
        let error = again(&file).unwrap_err();
        assert!(error.contains(word) && error.contains("other.mcap"), "{error}");
    }
    assert!(again(folder.path()).unwrap_err().contains("a directory"));
}
