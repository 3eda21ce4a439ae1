//! What editors read.

use landfall_lint::render::ReportFormat;
use snapbox::str;

use crate::findings::{plain, sample};
use crate::support::command::golden;

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
    golden().eq(&text, str![[r#"
: warning[stale-comment]
:1:3: error[stale-comment]
a b/c:d,e.frag:2:3: error[stale-comment] a b/c:d,e.frag
100 % of %0A and %25:3:3: warning[stale-comment] 100 % of %0A and %25
line break and return :4:3: error[stale-comment] line break and return
"quoted" 'single' `code` ``:5:3: error[stale-comment] "quoted" 'single' `code` ``
<failure message="x">&amp;]]></failure><!-- -->:6:3: warning[stale-comment] <failure message="x">&amp;]]></failure><!-- -->
a | b \| c \:7:3: error[stale-comment] a | b \| c \
./::error file=x::injected:8:3: error[stale-comment] ::error file=x::injected
#﹟[error]injected:9:3: warning[stale-comment] #﹟[error]injected
␛[31mred␛[0m ␀ ␡ � ￾      tab:10:3: error[stale-comment] ␛[31mred␛[0m ␀ ␡ � ￾      tab
漢字 🙂 é é �reversed�:11:3: error[stale-comment] 漢字 🙂 é é �reversed�
*bold* _slanted_ [link](http://example.com) # heading:12:3: warning[stale-comment] *bold* _slanted_ [link](http://example.com) # heading
{0} {{1}} ${{ secrets.X }} $(id) ${HOME}:13:3: error[stale-comment] {0} {{1}} ${{ secrets.X }} $(id) ${HOME}
../../etc/passwd:14:3: error[stale-comment] ../../etc/passwd
C:/windows/style.frag:15:3: warning[stale-comment] C:/windows/style.frag
/absolute/style.frag:16:3: error[stale-comment] /absolute/style.frag

"#]]);
}
