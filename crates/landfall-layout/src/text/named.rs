//! Enums whose variants have names.

/// Declares an enum by its variants and their names, with a list of all variants.
#[doc(hidden)]
#[macro_export]
macro_rules! named {
    (
        $(#[$attribute:meta])*
        pub enum $enum:ident {
            $($(#[$about:meta])* $variant:ident = $name:literal,)*
        }
    ) => {
        $(#[$attribute])*
        pub enum $enum {
            $($(#[$about])* $variant,)*
        }

        impl $enum {
            /// Every variant, in the order of the declaration.
            pub const ALL: [$enum; [$($name),*].len()] = [$($enum::$variant),*];

            /// The name that is printed and read.
            pub const fn name(self) -> &'static str {
                match self {
                    $($enum::$variant => $name,)*
                }
            }

            /// The variant of that name.
            pub fn from_name(name: &str) -> Option<$enum> {
                $enum::ALL.into_iter().find(|one| one.name() == name)
            }
        }
    };
}
