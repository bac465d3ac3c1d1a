"""The formats of trainers, written without their packages."""
