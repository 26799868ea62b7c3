//! What a user types and what comes back, word for word: usage errors, damaged files, and the
//! commands that only print. The transcripts are the files in `cmd`, beside the files they read.

#[test]
fn every_transcript_is_what_the_program_says() {
    trycmd::TestCases::new().case("tests/cmd/*.trycmd");
}
