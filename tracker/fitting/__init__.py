"""A pose, or the body's sizes, fitted to what the pictures show."""
