//! Arguments of `encode` and `decode`.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_layout::buffer::Missing;

use super::ReadArgs;

#[derive(Debug, clap::Args)]
pub struct EncodeArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "SHADER")]
    pub file: PathBuf,
    /// File with a JSON object of the block's members, also by path ("data[3].color"); - reads stdin
    #[arg(value_name = "VALUES", default_value = "-")]
    pub values: PathBuf,
    /// Name or instance name of the block [default: the only one]
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Treatment of members without a value
    #[arg(long, value_name = "HOW", default_value = "zero")]
    pub missing: Absent,
    /// Print a hex dump that names the component in each word, instead of the bytes; in lines of 16, 8
    /// or 4 bytes [default: the most that fit 80 columns]
    #[arg(
        long, value_name = "BYTES", num_args = 0..=1, require_equals = true,
        default_missing_value = "fit", value_parser = bytes_of_line
    )]
    pub hex: Option<HexLine>,
    /// Write to FILE instead of stdout; a failure leaves FILE unchanged
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Absent {
    /// Fill with zeros
    Zero,
    /// Report an error
    Error,
}

impl Absent {
    pub fn missing(self) -> Missing {
        match self {
            Absent::Zero => Missing::Zero,
            Absent::Error => Missing::Error,
        }
    }
}

#[derive(Debug, clap::Args)]
pub struct DecodeArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "SHADER")]
    pub file: PathBuf,
    /// File of bytes; - reads stdin
    #[arg(value_name = "BYTES")]
    pub bytes: PathBuf,
    /// Name or instance name of the block [default: the only one]
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Output format
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: DecodeFormat,
    /// Byte of the dump at which the block starts: 256, 0x100
    #[arg(long, value_name = "BYTE", value_parser = byte)]
    pub offset: Option<u64>,
    /// Only this member or element: data[3], data[3].color
    #[arg(long, value_name = "PATH")]
    pub only: Option<String>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DecodeFormat {
    /// A row per scalar, vector and matrix
    Table,
    /// JSON, as `landfall encode` reads it
    Json,
}

/// The bytes of a line of a hex dump; `None` for as many as fit.
#[derive(Clone, Copy, Debug)]
pub struct HexLine(pub Option<usize>);

fn bytes_of_line(text: &str) -> Result<HexLine, String> {
    match text {
        "fit" => Ok(HexLine(None)),
        "4" | "8" | "16" => Ok(HexLine(text.parse().ok())),
        _ => Err("a line has 4, 8 or 16 bytes".to_string()),
    }
}

/// Parses a decimal or hexadecimal byte offset: `256`, `0x100`.
pub fn byte(text: &str) -> Result<u64, String> {
    let parsed = match text.strip_prefix("0x") {
        // `from_str_radix` would accept a sign.
        Some(digits) if !digits.starts_with('+') => u64::from_str_radix(digits, 16),
        Some(_) | None => text.parse(),
    };
    parsed.map_err(|_| "a byte offset is a number such as 256 or 0x100".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_decimal_or_hexadecimal() {
        assert_eq!((byte("256"), byte("0x1f")), (Ok(256), Ok(31)));
        for text in ["", "-1", "0x", "0x+1", "0xg", "18446744073709551616"] {
            assert!(byte(text).is_err(), "{text}");
        }
    }
}
