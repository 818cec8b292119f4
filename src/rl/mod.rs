//! Reinforcement learning: PPO and what it needs. Knows no car.
