//! Assertions in C#, which has none at compile time: a class whose method throws, for a test.

use std::fmt::Write as _;

use super::{AssertionWriter, HostStructure, is_path, quoted};
use crate::language::CodeOptions;

pub(super) const CSHARP: AssertionWriter = AssertionWriter {
    field: str::to_string,
    is_structure: |name| is_path(name, "."),
    example: "Engine.PointLight",
    write,
};

fn write(structures: &[HostStructure], options: &CodeOptions) -> String {
    let mut text = format!(
        "
using System;
using System.Collections.Generic;
using System.Runtime.InteropServices;

// What structures of the program have to look like for the shaders.
public static class {}LayoutAssertions
{{
    // Throws with every difference, if there is one.
    public static void Check()
    {{
        List<string> found = new List<string>();
",
        crate::c::names::identifier_part(&options.prefix)
    );
    for HostStructure { host, what, fields, sizes, size_message } in structures {
        let _ = writeln!(text, "\n        // {host}: {what}");
        for field in fields {
            let name = quoted(&field.name);
            let at = format!("At(typeof({host}), {name})");
            same(
                &mut text,
                &at,
                &[field.offset],
                &format!("{host}.{}", field.name),
                &field.offset_message,
            );
            let size = format!("SizeOf(typeof({host}), {name})");
            same(
                &mut text,
                &size,
                &field.sizes,
                &format!("{host}.{}", field.name),
                &field.size_message,
            );
        }
        same(&mut text, &format!("Marshal.SizeOf(typeof({host}))"), sizes, host, size_message);
    }
    text.push_str(
        "
        if (found.Count > 0)
        {
            throw new InvalidOperationException(string.Join(\"\\n\", found));
        }
    }

    private static void Same(List<string> found, long actual, string message, params long[] allowed)
    {
        if (Array.IndexOf(allowed, actual) < 0)
        {
            found.Add(actual + \", not \" + allowed[allowed.Length - 1] + \": \" + message);
        }
    }

    // -1 where there is no such field.
    private static long At(Type type, string field)
    {
        return type.GetField(field, Fields) == null ? -1 : Marshal.OffsetOf(type, field).ToInt64();
    }

    private static long SizeOf(Type type, string name)
    {
        System.Reflection.FieldInfo field = type.GetField(name, Fields);
        if (field == null)
        {
            return -1;
        }
        MarshalAsAttribute array = (MarshalAsAttribute)Attribute.GetCustomAttribute(field, typeof(MarshalAsAttribute));
        if (array != null && array.Value == UnmanagedType.ByValArray)
        {
            return (long)array.SizeConst * Marshal.SizeOf(field.FieldType.GetElementType());
        }
        System.Runtime.CompilerServices.FixedBufferAttribute buffer =
            (System.Runtime.CompilerServices.FixedBufferAttribute)Attribute.GetCustomAttribute(
                field, typeof(System.Runtime.CompilerServices.FixedBufferAttribute));
        if (buffer != null)
        {
            return (long)buffer.Length * Marshal.SizeOf(buffer.ElementType);
        }
        if (field.FieldType == typeof(bool))
        {
            return sizeof(bool); // in the program's memory, not as it is marshalled
        }
        return Marshal.SizeOf(field.FieldType.IsEnum ? Enum.GetUnderlyingType(field.FieldType) : field.FieldType);
    }

    private const System.Reflection.BindingFlags Fields = System.Reflection.BindingFlags.Instance
        | System.Reflection.BindingFlags.Public | System.Reflection.BindingFlags.NonPublic;
}
",
    );
    text
}

fn same(text: &mut String, is: &str, allowed: &[u64], name: &str, message: &str) {
    if !allowed.is_empty() {
        let allowed: Vec<String> = allowed.iter().map(u64::to_string).collect();
        let message = quoted(&format!("{name}: {message}"));
        let _ = writeln!(
            text,
            "        Same(found, {is},\n            {message}, {});",
            allowed.join(", ")
        );
    }
}
