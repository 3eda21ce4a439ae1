//! What editors read.

use landfall_lint::render::ReportFormat;

use crate::findings::{plain, sample};

#[test]
fn a_finding_is_its_place_level_code_and_message() {
    assert_eq!(
        plain(&sample::findings(), ReportFormat::Short),
        "\
shaders/lights.frag:4:33: warning[stale-comment] the comment says `PointLight.color` is at byte 12, and it is at byte 16
shaders/lights.frag:7:24: error[block-mismatch] `PointLightBlock` has 6160 bytes here and 4112 bytes in `shaders/copy.vert`
layouts/gone.frag.json: warning[lock-orphan] this lock is of `shaders/gone.frag`, which is not there
"
    );
    assert_eq!(plain(&[], ReportFormat::Short), "");
}

#[test]
fn every_finding_takes_one_line() {
    let text = plain(&sample::hostile(), ReportFormat::Short);
    assert_eq!(text.lines().count(), sample::HOSTILE.len());
    assert!(text.contains("[stale-comment] line break and return\n"), "{text}");
}
