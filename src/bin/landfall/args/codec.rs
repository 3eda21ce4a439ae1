//! What `encode` and `decode` take.

use std::path::PathBuf;

use clap::ValueEnum;
use landfall_layout::buffer::Missing;

use super::ReadArgs;

#[derive(Debug, clap::Args)]
pub struct EncodeArgs {
    /// The shader; - reads stdin
    #[arg(value_name = "SHADER")]
    pub file: PathBuf,
    /// An object of the block's members, keys may be paths such as "data[3].color"; - reads stdin
    #[arg(value_name = "VALUES", default_value = "-")]
    pub values: PathBuf,
    /// The block, by its own name or its instance's [default: the only one]
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// What becomes of members that are not given
    #[arg(long, value_name = "WHAT", default_value = "zero")]
    pub missing: Absent,
    /// A hex dump with the component that each word is, instead of the bytes
    #[arg(long)]
    pub hex: bool,
    /// Write FILE, whole or not at all, instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Absent {
    Zero,
    Error,
}

impl Absent {
    pub fn becomes(self) -> Missing {
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
    /// The bytes; - reads stdin
    #[arg(value_name = "BYTES")]
    pub bytes: PathBuf,
    /// The block, by its own name or its instance's [default: the only one]
    #[arg(short, long, value_name = "NAME")]
    pub block: Option<String>,
    /// Form of the output
    #[arg(short, long, value_name = "FORMAT", default_value = "table")]
    pub format: DecodeFormat,
    /// Start at that byte of a longer dump: 256, 0x100
    #[arg(long, value_name = "BYTE", value_parser = byte)]
    pub offset: Option<u64>,
    /// Only what a path names: data[3], data[3].color
    #[arg(long, value_name = "PATH")]
    pub only: Option<String>,
    #[command(flatten)]
    pub read: ReadArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum DecodeFormat {
    /// A row for each scalar, vector and matrix
    Table,
    /// JSON that `landfall encode` takes
    Json,
}

/// `256`, `0x100`.
pub fn byte(text: &str) -> Result<u64, String> {
    let parsed = match text.strip_prefix("0x") {
        // A sign is no digit.
        Some(digits) if !digits.starts_with('+') => u64::from_str_radix(digits, 16),
        Some(_) | None => text.parse(),
    };
    parsed.map_err(|_| "a byte is a number such as 256 or 0x100".to_string())
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
