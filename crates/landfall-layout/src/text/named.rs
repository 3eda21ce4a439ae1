//! Enums whose variants have names.

/// Declares an enum by its variants and their names; `const ALL;` and `fn from_name;` behind it
/// add a list of all variants and the way back from a name.
#[doc(hidden)]
#[macro_export(local_inner_macros)]
macro_rules! named {
    (
        $(#[$attribute:meta])*
        $vis:vis enum $enum:ident {
            $($(#[$about:meta])* $variant:ident = $name:literal,)*
        }
    ) => {
        $(#[$attribute])*
        $vis enum $enum {
            $($(#[$about])* $variant,)*
        }

        impl $enum {
            /// The name that is printed and read.
            $vis const fn name(self) -> &'static str {
                match self {
                    $($enum::$variant => $name,)*
                }
            }
        }
    };
    (
        $(#[$attribute:meta])*
        $vis:vis enum $enum:ident {
            $($(#[$about:meta])* $variant:ident = $name:literal,)*
        }

        const ALL;
    ) => {
        named! {
            $(#[$attribute])*
            $vis enum $enum {
                $($(#[$about])* $variant = $name,)*
            }
        }

        impl $enum {
            /// Every variant, in the order of the declaration.
            $vis const ALL: [$enum; [$($name),*].len()] = [$($enum::$variant),*];
        }
    };
    ($(#[$attribute:meta])* $vis:vis enum $enum:ident $variants:tt const ALL; fn from_name;) => {
        named! {
            $(#[$attribute])*
            $vis enum $enum $variants

            const ALL;
        }

        impl $enum {
            /// The variant of that name.
            $vis fn from_name(name: &str) -> Option<$enum> {
                $enum::ALL.into_iter().find(|one| one.name() == name)
            }
        }
    };
}

pub(crate) use named;
