//! The settings of a user, as the client sends them under `landfall`.

use landfall_check::config::{self, Flags, GivenTargets};
use landfall_lint::settings::Target;
use serde::Deserialize;
use serde_json::Value;

/// The settings; a key that is missing has its default.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct EditorSettings {
    pub inlay_hints: HintSettings,
    /// Targets whose limits and dialect apply, instead of the configuration's: `vulkan`, `webgpu`.
    pub targets: Vec<String>,
    /// Macros, `NAME` or `NAME=TEXT`, over those of the configuration.
    pub defines: Vec<String>,
    /// Features of WESL, `NAME` or `NAME=false`.
    pub features: Vec<String>,
    /// The address of the pages about lints, `{code}` standing for the lint's.
    pub rule_pages: Option<String>,
}

/// Which inlay hints are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct HintSettings {
    /// Offsets of members.
    pub offsets: bool,
    /// Sizes of members.
    pub sizes: bool,
    /// Strides of members that are arrays.
    pub strides: bool,
    /// Holes beside members.
    pub padding: bool,
    /// Sizes of blocks and structures, with their padding.
    pub blocks: bool,
}

impl Default for HintSettings {
    fn default() -> HintSettings {
        HintSettings { offsets: true, sizes: false, strides: false, padding: true, blocks: true }
    }
}

/// The same without keys that are `null`, which editors send for what is not set.
fn without_nulls(value: &Value) -> Value {
    match value {
        Value::Object(keys) => {
            let set = keys.iter().filter(|(_, value)| !value.is_null());
            Value::Object(set.map(|(key, value)| (key.clone(), without_nulls(value))).collect())
        }
        other => other.clone(),
    }
}

impl EditorSettings {
    /// The settings of a JSON object, or of one that has it under `landfall`; the defaults for `null`.
    ///
    /// # Errors
    ///
    /// A key has a value of the wrong type.
    pub fn read(value: &Value) -> Result<EditorSettings, String> {
        let value = value.get("landfall").unwrap_or(value);
        if value.is_null() {
            return Ok(EditorSettings::default());
        }
        EditorSettings::deserialize(without_nulls(value))
            .map_err(|cause| format!("the settings of landfall cannot be read: {cause}"))
    }

    /// The flags of a check.
    ///
    /// # Errors
    ///
    /// A target, macro or feature that is none.
    pub fn flags(&self) -> Result<Flags, String> {
        let mut flags = Flags::default();
        let defines = self.defines.iter().map(|text| (text, config::define(text)));
        let features = self.features.iter().map(|text| (text, config::feature(text)));
        for (text, define) in defines.chain(features) {
            flags.defines.push(define.map_err(|cause| format!("`{text}`: {cause}"))?);
        }
        let mut limits = Vec::new();
        for name in &self.targets {
            let known = Target::from_name(name);
            limits.push(known.ok_or_else(|| format!("`{name}` is not a target"))?);
        }
        if !limits.is_empty() {
            let dialect = config::dialect(limits.iter().filter_map(|one| one.dialect()));
            flags.targets = Some(GivenTargets { dialect, limits });
        }
        Ok(flags)
    }
}
