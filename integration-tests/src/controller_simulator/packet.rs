//! The packet of the feedback port, from the table in chapter 3 of the maker's manual for version 4 (4 for version 3).

/// What a packet says; degrees.
#[derive(Debug, Clone, Copy)]
pub struct Said {
    pub mode: u64,
    pub time_ms: u64,
    pub enabled: bool,
    pub alarm: bool,
    pub running: bool,
    pub robot_type: u8,
    pub q_target: [f64; 6],
    pub qd_target: [f64; 6],
    pub q_actual: [f64; 6],
    pub qd_actual: [f64; 6],
}

/// The 1440 bytes, little endian.
pub fn packet(said: &Said) -> [u8; 1440] {
    let mut bytes = [0u8; 1440];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, &1440u16.to_le_bytes()); // 0000-0001 MessageSize
    put(24, &said.mode.to_le_bytes()); // 0024-0031 RobotMode
    put(32, &(1_700_000_000_000 + said.time_ms).to_le_bytes()); // 0032-0039 TimeStamp
    put(40, &said.time_ms.to_le_bytes()); // 0040-0047 RunTime
    put(48, &0x0123_4567_89AB_CDEFu64.to_le_bytes()); // 0048-0055 TestValue
    put(64, &100f64.to_le_bytes()); // 0064-0071 SpeedScaling
    put(88, &48f64.to_le_bytes()); // 0088-0095 VRobot
    for k in 0..6 {
        put(192 + 8 * k, &said.q_target[k].to_le_bytes()); // 0192-0239 QTarget
        put(240 + 8 * k, &said.qd_target[k].to_le_bytes()); // 0240-0287 QDTarget
        put(432 + 8 * k, &said.q_actual[k].to_le_bytes()); // 0432-0479 QActual
        put(480 + 8 * k, &said.qd_actual[k].to_le_bytes()); // 0480-0527 QDActual
        put(864 + 8 * k, &35f64.to_le_bytes()); // 0864-0911 MotorTemperatures
        put(912 + 8 * k, &8f64.to_le_bytes()); // 0912-0959 JointModes: 8 is position
    }
    put(1014, &[u8::from(said.running)]); // 1014 RunQueuedCmd
    put(1016, &[100, 100]); // 1016 VelocityRatio, 1017 AccelerationRatio
    put(1026, &[u8::from(said.enabled)]); // 1026 EnableStatus
    put(1028, &[u8::from(said.running)]); // 1028 RunningStatus
    put(1029, &[u8::from(said.alarm)]); // 1029 ErrorStatus
    put(1031, &[said.robot_type]); // 1031 CRRobotType
    bytes
}
