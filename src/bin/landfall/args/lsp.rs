//! Arguments of `lsp`.

#[derive(Debug, clap::Args)]
pub struct LspArgs {
    /// Speak over standard input and output, which is the only way: some editors pass it
    #[arg(long)]
    pub stdio: bool,
}
