//! The macro that writes reports as JSON documents, with the keys in the order of the source text.

/// Builds a JSON document from keys and values. If `if some` follows a key, its value is an
/// [`Option`], and the key is omitted if the value is [`None`].
macro_rules! document {
    (@type $key:ident) => { $key };
    (@type $key:ident $some:ident) => { Option<$key> };
    (@entry $keys:ident $name:expr, $value:expr) => { $keys.serialize_entry($name, $value)? };
    (@entry $keys:ident $name:expr, $value:expr, $some:ident) => {
        if let Some(value) = $value {
            $keys.serialize_entry($name, value)?;
        }
    };
    ($($key:ident $(if $some:ident)?: $value:expr),* $(,)?) => {{
        #[allow(non_camel_case_types)]
        struct Document<$($key),*> {
            $($key: document!(@type $key $($some)?)),*
        }

        #[allow(non_camel_case_types)]
        impl<$($key: serde::Serialize),*> serde::Serialize for Document<$($key),*> {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                use serde::ser::SerializeMap;
                let mut keys = serializer.serialize_map(None)?;
                $(document!(@entry keys stringify!($key), &self.$key $(, $some)?);)*
                keys.end()
            }
        }

        Document { $($key: $value),* }
    }};
}
