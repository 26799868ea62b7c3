//! What a user types and what comes back, word for word: usage errors, damaged files, and the
//! commands that only print. The transcripts are the files in `cmd`, beside the files they read.
//! With `TRYCMD=overwrite` this test writes them anew, for a person to review.

#[test]
fn every_transcript_is_what_the_program_says() {
    // So that the transcripts name their files by short paths, as a user would.
    std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cmd"))
        .expect("this test's own folder");
    trycmd::TestCases::new().case("*.trycmd");
}
