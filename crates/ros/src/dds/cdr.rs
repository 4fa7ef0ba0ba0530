//! Encoding and decoding of messages in plain little-endian CDR, with its four-byte encapsulation header. Any other
//! encapsulation, such as big-endian CDR, is rejected.

use std::io;

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Encapsulation header of plain CDR, little endian.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Encodes a message as it is sent over the network.
pub fn encode<M: Serialize>(message: &M) -> Result<Vec<u8>, String> {
    let mut bytes = HEADER.to_vec();
    cdr_encoding::to_writer::<_, LittleEndian, _>(&mut bytes, message).map_err(|error| error.to_string())?;
    Ok(bytes)
}

/// Encoded size of a message in bytes. For a message that cannot be encoded: number of bytes written before the error.
pub fn size_of(message: &impl Serialize) -> usize {
    let mut counter = Counter(HEADER.len());
    let _ = cdr_encoding::to_writer::<_, LittleEndian, _>(&mut counter, message);
    counter.0
}

/// Writer that only counts the bytes.
struct Counter(usize);

impl io::Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The message that is decoded from zero bytes: empty text, empty lists, zero numbers. Fails for a message with a large
/// array of fixed length.
pub fn blank<M: DeserializeOwned>() -> Result<M, String> {
    const ZEROS: [u8; 4096] = [0; 4096];
    cdr_encoding::from_bytes::<M, LittleEndian>(&ZEROS)
        .map(|(message, _)| message)
        .map_err(|error| error.to_string())
}

/// Decodes a message from untrusted bytes.
pub fn decode<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, String> {
    let body = bytes.strip_prefix(&HEADER).ok_or("is not plain CDR, little end first")?;
    let decoded = cdr_encoding::from_bytes::<M, LittleEndian>(body);
    decoded.map(|(message, _)| message).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use ros2_client::rcl_interfaces::{GetParametersResponse, ListParametersResponse};
    use ros2_interfaces_jazzy_serde::moveit_msgs::srv::{GetPlanningSceneResponse, GetStateValidityResponse};

    use super::*;
    use crate::messages::clearance_srvs::{
        CheckMotionsResponse, CheckStatesResponse, CheckTrajectoryResponse, FindFreeStateResponse,
        GetDistancesResponse,
    };

    /// Whether a blank message is short and does not change when it is encoded and decoded.
    fn is_blank<M: Serialize + DeserializeOwned>() -> bool {
        let bytes = encode(&blank::<M>().unwrap()).unwrap();
        bytes.len() < 1000 && encode(&decode::<M>(&bytes).unwrap()).unwrap() == bytes
    }

    #[test]
    fn every_response_that_may_be_long_has_a_blank_one() {
        assert!(is_blank::<GetPlanningSceneResponse>() && is_blank::<GetStateValidityResponse>());
        assert!(is_blank::<CheckMotionsResponse>());
        assert!(is_blank::<CheckStatesResponse>() && is_blank::<GetDistancesResponse>());
        assert!(is_blank::<CheckTrajectoryResponse>() && is_blank::<FindFreeStateResponse>());
        assert!(is_blank::<GetParametersResponse>());
        assert!(is_blank::<ListParametersResponse>());
    }
}
