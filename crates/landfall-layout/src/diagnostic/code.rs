//! The codes of diagnostics, one list for every crate that makes them.
//!
//! Lints and hazards have tables of their own: a finding's code is a text, because caches and
//! merged reports hold findings of other versions.

use std::fmt;

use serde::{Serialize, Serializer};

macro_rules! codes {
    ($($variant:ident = $text:literal;)*) => {
        /// The kind of a [`Diagnostic`](super::Diagnostic).
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Code {
            $(#[doc = concat!("Printed as `", $text, "`.")] $variant,)*
        }

        impl Code {
            /// Every code, in the order of their names.
            pub const ALL: &[Code] = &[$(Code::$variant),*];

            /// Returns the name that is printed: `unknown-type`.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Code::$variant => $text,)*
                }
            }
        }
    };
}

codes! {
    AmbiguousBlock = "ambiguous-block";
    AmbiguousFunction = "ambiguous-function";
    ArraySize = "array-size";
    Backend = "backend";
    BadDomain = "bad-domain";
    BadGlob = "bad-glob";
    BadName = "bad-name";
    BadPlanes = "bad-planes";
    BadRequest = "bad-request";
    BadRust = "bad-rust";
    Bind = "bind";
    BlockTooLarge = "block-too-large";
    BrokenType = "broken-type";
    ByteOrderMark = "byte-order-mark";
    ByteOutOfRange = "byte-out-of-range";
    CannotBench = "cannot-bench";
    CannotCall = "cannot-call";
    CannotCompare = "cannot-compare";
    CannotRun = "cannot-run";
    CannotWrite = "cannot-write";
    Condition = "condition";
    CyclicInclude = "cyclic-include";
    DuplicateName = "duplicate-name";
    EmptyCone = "empty-cone";
    EmptyFile = "empty-file";
    EmptyInput = "empty-input";
    EmptyStruct = "empty-struct";
    ErrorDirective = "error-directive";
    F16NotEnabled = "f16-not-enabled";
    GivenTwice = "given-twice";
    HardCone = "hard-cone";
    Include = "include";
    IncludeBomb = "include-bomb";
    IndexOutOfRange = "index-out-of-range";
    Infinite = "infinite";
    InternalError = "internal-error";
    InvalidAlign = "invalid-align";
    InvalidAttribute = "invalid-attribute";
    InvalidShader = "invalid-shader";
    InvalidSize = "invalid-size";
    InvalidSpirv = "invalid-spirv";
    JsonSyntax = "json-syntax";
    LayoutQualifier = "layout-qualifier";
    LineContinuation = "line-continuation";
    LockOrphan = "lock-orphan";
    LoneConstant = "lone-constant";
    LooseUniform = "loose-uniform";
    MacroBomb = "macro-bomb";
    MacroCall = "macro-call";
    MacroRedefined = "macro-redefined";
    MalformedPath = "malformed-path";
    MeshWithoutNormals = "mesh-without-normals";
    MisalignedOffset = "misaligned-offset";
    MissingInclude = "missing-include";
    MissingIndex = "missing-index";
    MissingKey = "missing-key";
    MissingMaterial = "missing-material";
    MissingMember = "missing-member";
    MoreFindings = "more-findings";
    NarrowCone = "narrow-cone";
    NeedsTail = "needs-tail";
    NegativeAttenuation = "negative-attenuation";
    NegativeColor = "negative-color";
    NestedTooDeep = "nested-too-deep";
    NoBinding = "no-binding";
    NoBlocks = "no-blocks";
    NoBytes = "no-bytes";
    NoCMirror = "no-c-mirror";
    NoIncludeDir = "no-include-dir";
    NoInput = "no-input";
    NoLights = "no-lights";
    NoOverload = "no-overload";
    NoTail = "no-tail";
    NonzeroPadding = "nonzero-padding";
    NotALeaf = "not-a-leaf";
    NotANumber = "not-a-number";
    NotAStructure = "not-a-structure";
    NotAnArray = "not-an-array";
    NotAnalysed = "not-analysed";
    NotFinite = "not-finite";
    NotHostShareable = "not-host-shareable";
    NotMirrored = "not-mirrored";
    NotPortable = "not-portable";
    NotUtf8 = "not-utf8";
    NumberedName = "numbered-name";
    OddBool = "odd-bool";
    OddLength = "odd-length";
    OffsetGoesBack = "offset-goes-back";
    OffsetOutOfRange = "offset-out-of-range";
    OpaqueInBlock = "opaque-in-block";
    OpaqueMember = "opaque-member";
    OtherBlock = "other-block";
    OtherLanguage = "other-language";
    OutOfBounds = "out-of-bounds";
    OverlappingMembers = "overlapping-members";
    OverrideSizedArray = "override-sized-array";
    OverrideValue = "override-value";
    PolicyForbids = "policy-forbids";
    Preprocessor = "preprocessor";
    Recursion = "recursion";
    RecursiveConstant = "recursive-constant";
    RecursiveStruct = "recursive-struct";
    RuntimeSizedArray = "runtime-sized-array";
    StaleLock = "stale-lock";
    StaleOutput = "stale-output";
    SuspiciousUnit = "suspicious-unit";
    SwappedCone = "swapped-cone";
    Syntax = "syntax";
    TargetChangesLayout = "target-changes-layout";
    TooLarge = "too-large";
    TooManyElements = "too-many-elements";
    TooManyLights = "too-many-lights";
    TooManyMembers = "too-many-members";
    UnclosedBrace = "unclosed-brace";
    UnclosedComment = "unclosed-comment";
    UndefinedFunction = "undefined-function";
    UndefinedMacro = "undefined-macro";
    UndefinedOperation = "undefined-operation";
    UnexpectedToken = "unexpected-token";
    UniformConstraints = "uniform-constraints";
    UnknownAddressSpace = "unknown-address-space";
    UnknownAttribute = "unknown-attribute";
    UnknownBlock = "unknown-block";
    UnknownDirective = "unknown-directive";
    UnknownFunction = "unknown-function";
    UnknownInput = "unknown-input";
    UnknownKey = "unknown-key";
    UnknownLint = "unknown-lint";
    UnknownMember = "unknown-member";
    UnknownName = "unknown-name";
    UnknownOverride = "unknown-override";
    UnknownQuantity = "unknown-quantity";
    UnknownTarget = "unknown-target";
    UnknownTexture = "unknown-texture";
    UnknownType = "unknown-type";
    UnmatchedDirective = "unmatched-directive";
    UnreachedBlock = "unreached-block";
    UnreadableFile = "unreadable-file";
    UnreadableLock = "unreadable-lock";
    UnsizedBlock = "unsized-block";
    UnusedOption = "unused-option";
    UpAlongFront = "up-along-front";
    ValueOutOfRange = "value-out-of-range";
    Version = "version";
    WhichBlock = "which-block";
    WrongCone = "wrong-cone";
    WrongCount = "wrong-count";
    WrongIndices = "wrong-indices";
    WrongLength = "wrong-length";
    WrongMesh = "wrong-mesh";
    WrongSize = "wrong-size";
    WrongTexture = "wrong-texture";
    WrongType = "wrong-type";
    WrongUnit = "wrong-unit";
    WrongValue = "wrong-value";
    ZeroAttenuation = "zero-attenuation";
    ZeroDirection = "zero-direction";
    ZeroShininess = "zero-shininess";
}

impl Code {
    /// Whether a shader is not parsed further after an error of this code.
    pub fn ends_parsing(self) -> bool {
        matches!(
            self,
            Code::InvalidSpirv
                | Code::Syntax
                | Code::UnexpectedToken
                | Code::UnclosedBrace
                | Code::UnclosedComment
                | Code::UnmatchedDirective
        )
    }

    /// Returns the code of that name.
    pub fn from_name(name: &str) -> Option<Code> {
        Code::ALL.iter().copied().find(|code| code.name() == name)
    }
}

impl AsRef<str> for Code {
    fn as_ref(&self) -> &str {
        self.name()
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl PartialEq<str> for Code {
    fn eq(&self, name: &str) -> bool {
        self.name() == name
    }
}

impl PartialEq<&str> for Code {
    fn eq(&self, name: &&str) -> bool {
        self.name() == *name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_sorted_kebab_case_and_lead_back_to_their_codes() {
        assert!(Code::ALL.is_sorted_by(|a, b| a.name() < b.name()));
        for code in Code::ALL {
            let kebab = |c: char| c == '-' || c.is_ascii_lowercase() || c.is_ascii_digit();
            assert!(code.name().chars().all(kebab), "{code}");
            assert_eq!(Code::from_name(code.name()), Some(*code));
        }
        assert_eq!(Code::from_name("none-such"), None);
    }
}
