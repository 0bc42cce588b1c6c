//! `read-ndm FILE`: an attitude ephemeris as that reader understands it, in JSON.

use ccsds_ndm::{MessageType, from_file, traits::Validate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name a file")?;
    let MessageType::Aem(message) = from_file(&path)? else { return Err("this is no AEM".into()) };
    message.validate()?;
    println!("{}", serde_json::to_string(&message)?);
    Ok(())
}
