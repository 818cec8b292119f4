//! The encoding of an ONNX file: fields of protocol buffers. No length in them is trusted.

/// Why a file is refused.
pub type Refusal = String;

/// The content of a field.
#[derive(Clone, Copy)]
pub enum Content<'a> {
    Number(u64),
    Bytes(&'a [u8]),
}

/// Takes the next field of a message: its number and its content; `None` at the end.
///
/// # Errors
/// The bytes are not a field.
fn field<'a>(bytes: &mut &'a [u8]) -> Result<Option<(u32, Content<'a>)>, Refusal> {
    let short = || "it ends in the middle of a value".to_owned();
    if bytes.is_empty() {
        return Ok(None);
    }
    let tag = u32::try_from(varint(bytes)?).map_err(|_| "it has a field without a number")?;
    let content = match tag & 7 {
        0 => Content::Number(varint(bytes)?),
        1 => Content::Number(u64::from_le_bytes(split(bytes, 8)?.try_into().map_err(|_| short())?)),
        2 => {
            let length = usize::try_from(varint(bytes)?).map_err(|_| short())?;
            Content::Bytes(split(bytes, length)?)
        }
        5 => Content::Number(u32::from_le_bytes(split(bytes, 4)?.try_into().map_err(|_| short())?).into()),
        _ => return Err("it has a field of no known encoding".into()),
    };
    if tag >> 3 == 0 {
        return Err("it has a field without a number".into());
    }
    Ok(Some((tag >> 3, content)))
}

/// Calls a function with each field of a message.
///
/// # Errors
/// The bytes are not fields, and those of the function.
pub fn fields<'a>(
    mut bytes: &'a [u8],
    each: &mut dyn FnMut(u32, Content<'a>) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    while let Some((number, content)) = field(&mut bytes)? {
        each(number, content)?;
    }
    Ok(())
}

fn split<'a>(bytes: &mut &'a [u8], length: usize) -> Result<&'a [u8], Refusal> {
    let (first, rest) = bytes.split_at_checked(length).ok_or("it ends in the middle of a value")?;
    *bytes = rest;
    Ok(first)
}

fn varint(bytes: &mut &[u8]) -> Result<u64, Refusal> {
    let mut number = 0_u64;
    for place in 0..10 {
        let byte = split(bytes, 1)?[0];
        number |= u64::from(byte & 0x7f).checked_shl(7 * place).unwrap_or(0);
        if byte < 0x80 {
            return Ok(number);
        }
    }
    Err("it has a number of more than 64 bits".into())
}

/// Appends whole numbers, which are written one by one or together.
///
/// # Errors
/// The bytes are not numbers.
pub fn whole_numbers(content: Content, to: &mut Vec<i64>) -> Result<(), Refusal> {
    match content {
        Content::Number(number) => to.push(number as i64),
        Content::Bytes(mut bytes) => {
            while !bytes.is_empty() {
                to.push(varint(&mut bytes)? as i64);
            }
        }
    }
    Ok(())
}

/// Bytes as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
