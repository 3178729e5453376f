"""Compiled loops only: private, unchecked, pure; they never write their inputs unless the name says so."""
