"""Data for training: episodes, the files that trainers read, and demonstrations from files of others."""
