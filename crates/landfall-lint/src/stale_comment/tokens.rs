//! Splits a comment into words, numbers and signs, in English, German and Chinese.
//!
//! Used by [`claims`](super::claims).

use std::ops::Range;

/// The quantity that a claim states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Offset,
    Align,
    Size,
    /// The stride of elements, of columns, or of either.
    ArrayStride,
    MatrixStride,
    Stride,
    /// The size of the structure or block as a whole.
    Total,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CommentNumber {
    pub value: u64,
    /// The range of bytes in the comment.
    pub range: Range<usize>,
    pub hex: bool,
}

/// A piece of a comment.
#[derive(Clone, Debug)]
pub(super) struct CommentWord {
    pub sign: Sign,
    /// Bytes of the comment it takes up.
    pub range: Range<usize>,
    /// The text in lower case.
    pub lower: String,
}

#[derive(Clone, Debug)]
pub(super) enum Sign {
    /// A word that names a quantity.
    Keyword(Kind),
    /// Bytes.
    Unit,
    Number(CommentNumber),
    Text,
    /// One character; Chinese punctuation as its ASCII counterpart.
    Mark(char),
    /// Numbers that are not whole bytes: `0.5`, `4x4`, `16b`.
    Odd,
}

/// The words that name a quantity; of two with a common beginning, the longer one is first.
const KEYWORDS: &[(&str, Kind)] = &[
    ("alignment", Kind::Align),
    ("align", Kind::Align),
    ("offsets", Kind::Offset),
    ("offset", Kind::Offset),
    ("arraystride", Kind::ArrayStride),
    ("matrixstride", Kind::MatrixStride),
    ("stride", Kind::Stride),
    ("sizeof", Kind::Size),
    ("size", Kind::Size),
    ("total", Kind::Total),
    ("sum", Kind::Total),
    ("versatz", Kind::Offset),
    ("ausrichtung", Kind::Align),
    ("größe", Kind::Size),
    ("groesse", Kind::Size),
    ("schrittweite", Kind::Stride),
    ("gesamtgröße", Kind::Total),
    ("gesamtgroesse", Kind::Total),
    ("insgesamt", Kind::Total),
    ("gesamt", Kind::Total),
    ("基准对齐量", Kind::Align),
    ("基准对齐", Kind::Align),
    ("对齐偏移量", Kind::Offset),
    ("对齐偏移", Kind::Offset),
    ("字节对齐", Kind::Align),
    ("对齐字节", Kind::Align),
    ("对齐量", Kind::Align),
    ("对齐值", Kind::Align),
    ("对齐", Kind::Align),
    ("字节偏移量", Kind::Offset),
    ("字节偏移", Kind::Offset),
    ("起始偏移", Kind::Offset),
    ("偏移量", Kind::Offset),
    ("偏移", Kind::Offset),
    ("数组步长", Kind::ArrayStride),
    ("数组跨度", Kind::ArrayStride),
    ("矩阵步长", Kind::MatrixStride),
    ("步长", Kind::Stride),
    ("跨度", Kind::Stride),
    ("总字节数", Kind::Total),
    ("总大小", Kind::Total),
    ("总共", Kind::Total),
    ("一共", Kind::Total),
    ("总计", Kind::Total),
    ("合计", Kind::Total),
    ("字节大小", Kind::Size),
    ("大小", Kind::Size),
];

/// The phrases that name a quantity.
const PHRASES: &[(&[&str], Kind)] = &[
    (&["array", "stride"], Kind::ArrayStride),
    (&["matrix", "stride"], Kind::MatrixStride),
    (&["total", "size"], Kind::Total),
    (&["total", "bytes"], Kind::Total),
    (&["struct", "size"], Kind::Total),
    (&["block", "size"], Kind::Total),
];

/// The Chinese words that are recognised without separators.
const SHORT: &[&str] = &["占用", "占", "为", "是", "到", "至", "原来", "之前", "如果"];

/// Whether a comment may state a number; most have none, and need not be split.
pub(super) fn has_digit(comment: &str) -> bool {
    comment.bytes().any(|byte| byte.is_ascii_digit())
}

pub(super) fn tokens(comment: &str) -> Vec<CommentWord> {
    let mut words: Vec<CommentWord> = Vec::new();
    let mut at = opening(comment);
    let end = comment.len() - comment.ends_with("*/") as usize * 2;
    let end = end.max(at);
    while at < end {
        let rest = &comment[at..end];
        let sign = rest.chars().next().expect("the rest is not empty");
        let (sign, length) = match sign {
            '\n' => (Some(Sign::Mark('\n')), 1),
            sign if sign.is_whitespace() => (None, sign.len_utf8()),
            sign if sign.is_ascii_digit() => number(comment, at, end),
            '@' if rest[1..].trim_start().starts_with(|c: char| c.is_ascii_digit()) => {
                (Some(Sign::Keyword(Kind::Offset)), 1)
            }
            sign if is_latin(sign) || sign == '_' => {
                let length = rest
                    .find(|c: char| !is_latin(c) && !c.is_ascii_digit() && c != '_')
                    .unwrap_or(rest.len());
                (Some(latin(&rest[..length])), length)
            }
            // Chinese has no spaces between words.
            sign if sign.is_alphabetic() => chinese(rest),
            sign => (Some(Sign::Mark(ascii_counterpart(sign))), sign.len_utf8()),
        };
        if let Some(sign) = sign {
            let range = at..at + length;
            let lower = comment[range.clone()].to_lowercase();
            words.push(CommentWord { sign, range, lower });
        }
        at += length;
    }
    phrases(words)
}

/// Returns the number of bytes of the comment's opening delimiter.
fn opening(comment: &str) -> usize {
    let body = comment.trim_start_matches(['/', '*', '!', '<', '#']);
    comment.len() - body.len()
}

/// Whether a character is a letter of the Latin alphabet, such as those of `Größe`.
fn is_latin(c: char) -> bool {
    c.is_ascii_alphabetic() || (c.is_alphabetic() && ('\u{c0}'..='\u{24f}').contains(&c))
}

fn latin(word: &str) -> Sign {
    let lower = word.to_lowercase();
    if let "byte" | "bytes" = &*lower {
        return Sign::Unit;
    }
    let keyword = KEYWORDS.iter().find(|(keyword, _)| *keyword == lower);
    keyword.map_or(Sign::Text, |(_, kind)| Sign::Keyword(*kind))
}

/// The longest known word that starts here, or everything up to the next one.
fn chinese(rest: &str) -> (Option<Sign>, usize) {
    let known = |rest: &str| {
        let keyword = KEYWORDS.iter().find(|(keyword, _)| rest.starts_with(keyword));
        let keyword = keyword.map(|(keyword, kind)| (Sign::Keyword(*kind), keyword.len()));
        let unit = || rest.starts_with("字节").then(|| (Sign::Unit, "字节".len()));
        let short = || {
            let word = SHORT.iter().find(|word| rest.starts_with(**word));
            word.map(|word| (Sign::Text, word.len()))
        };
        keyword.or_else(unit).or_else(short)
    };
    if let Some((sign, length)) = known(rest) {
        return (Some(sign), length);
    }
    let ends = |(at, sign): (usize, char)| {
        sign.is_ascii() || !sign.is_alphabetic() || (at > 0 && known(&rest[at..]).is_some())
    };
    let length = rest.char_indices().find(|&place| ends(place)).map_or(rest.len(), |(at, _)| at);
    (Some(Sign::Text), length)
}

fn number(comment: &str, at: usize, end: usize) -> (Option<Sign>, usize) {
    let rest = &comment[at..end];
    let hex = rest.strip_prefix("0x").or_else(|| rest.strip_prefix("0X"));
    let (digits, radix, skip) = match hex {
        Some(digits) => (digits, 16, 2),
        None => (rest, 10, 0),
    };
    let length = digits.find(|c: char| !c.is_digit(radix)).unwrap_or(digits.len());
    let whole = skip + length;
    let after = &rest[whole..];
    let word = after.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(after.len());
    // `16bytes` and `16B` are bytes; `16b`, `4x4`, `2D`, `1f` are something else.
    let is_unit = matches!(&after[..word], "" | "bytes" | "byte" | "Bytes" | "B");
    let mut signs = after[word..].chars();
    let (next, second) = (signs.next(), signs.next());
    let fraction = matches!(next, Some('.' | ',')) && second.is_some_and(|c| c.is_ascii_digit());
    // A part of `2*3` or `4+4`.
    let reckoned = matches!(next, Some('*' | '+' | '%' | '^' | '\''));
    let before = comment[..at].chars().next_back();
    // `-3`, but not the end of `16-28`.
    let negative = before == Some('-')
        && !comment[..at - 1].trim_end().ends_with(|c: char| c.is_ascii_digit());
    let part = matches!(before, Some('.' | '+' | '*' | '<' | '>' | '$' | '#'))
        && !comment[..at].ends_with("..");
    let value = u64::from_str_radix(&digits[..length], radix).ok();
    match value {
        Some(value) if is_unit && !fraction && !reckoned && !negative && !part => {
            let number = CommentNumber { value, range: at..at + whole, hex: skip > 0 };
            (Some(Sign::Number(number)), whole)
        }
        _ => (Some(Sign::Odd), (whole + word).max(1)),
    }
}

fn ascii_counterpart(sign: char) -> char {
    match sign {
        '：' => ':',
        '，' | '、' => ',',
        '；' => ';',
        '（' => '(',
        '）' => ')',
        '。' => '.',
        '＝' => '=',
        '～' => '~',
        other => other,
    }
}

/// Joins the words of terms of several words.
fn phrases(words: Vec<CommentWord>) -> Vec<CommentWord> {
    let mut joined: Vec<CommentWord> = Vec::with_capacity(words.len());
    let mut at = 0;
    while at < words.len() {
        let fits = |phrase: &[&str]| {
            words.len() >= at + phrase.len()
                && phrase.iter().zip(&words[at..]).all(|(want, word)| word.lower == *want)
        };
        // `16B`: the unit is a word of its own.
        let mut word = words[at].clone();
        if word.lower == "b" && matches!(joined.last().map(|w| &w.sign), Some(Sign::Number(_))) {
            word.sign = Sign::Unit;
        }
        match PHRASES.iter().find(|(phrase, _)| fits(phrase)) {
            Some((phrase, kind)) => {
                let last = &words[at + phrase.len() - 1];
                word.range.end = last.range.end;
                word.sign = Sign::Keyword(*kind);
                at += phrase.len();
            }
            None => at += 1,
        }
        joined.push(word);
    }
    joined
}
