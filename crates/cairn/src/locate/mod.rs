//! Where the robot is: encoders and gyroscope fused.
