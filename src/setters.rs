//! The macro that writes the setters of parameters.

/// Setters of a struct of parameters, each of which takes the struct and hands it on: name, argument, the field and its new value.
macro_rules! setters {
    ($params:ty: $(
        $(#[$doc:meta])*
        $name:ident($argument:ident: $type:ty) => $field:ident = $value:expr;
    )*) => {
        impl $params {
            /// The defaults.
            pub fn new() -> Self {
                Self::default()
            }

            $(
                $(#[$doc])*
                #[must_use]
                pub fn $name(mut self, $argument: $type) -> Self {
                    self.$field = $value;
                    self
                }
            )*
        }
    };
}
pub(crate) use setters;
